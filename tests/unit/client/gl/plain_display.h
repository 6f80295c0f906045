#pragma once
/// All that Display shows by one plain shader, which decides at each pixel what is shown there.
#include <client/view/gl/display.h>

#include <equistream/conventions.h>
#include <equistream/text.h>

#include <array>
#include <string>
#include <vector>

namespace equistream::test {

inline constexpr const char* plain_display_text = R"glsl(
layout(binding = 0) uniform sampler2DArray eyes;
layout(binding = 1) uniform usampler2DArray origins;
layout(binding = 2) uniform sampler2DArray eye_depth;
layout(binding = 3) uniform sampler2DArray reliability;
layout(binding = 4) uniform sampler2DArray other_eyes;
layout(binding = 5) uniform sampler2D source;
layout(binding = 6) uniform sampler2DArray motion;

uniform int layout_shown;
uniform int overlay;
uniform float depth_scale;
uniform int has_reliability;
uniform int has_motion;
uniform ivec2 eye_size;
uniform ivec2 window_size;
uniform mat3 from_left;
uniform mat3 from_right;
uniform vec3 lens;
uniform float fading;
uniform float split;

out vec4 colour;

vec3 to_linear(vec3 display) {
    return mix(display / 12.92, pow((display + 0.055) / 1.055, vec3(2.4)), greaterThan(display, vec3(0.04045)));
}

vec3 to_display(vec3 linear) {
    linear = clamp(linear, 0.0, 1.0);
    return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, greaterThan(linear, vec3(0.0031308)));
}

/// Near is warm, far is cold; 1 / m on a scale that tells rooms and streets apart.
vec3 depth_colour(float inverse_m) {
    if (!(inverse_m > 0.0))
        return vec3(0.05, 0.05, 0.1);
    float near = clamp(1.0 / (1.0 + 0.25 / inverse_m), 0.0, 1.0);
    return mix(mix(vec3(0.1, 0.2, 0.6), vec3(0.1, 0.8, 0.5), clamp(2.0 * near, 0.0, 1.0)), vec3(1.0, 0.75, 0.1),
               clamp(2.0 * near - 1.0, 0.0, 1.0));
}

/// Who coloured a pixel, in the order of PixelOrigin.
const vec3 origin_colours[10] =
    vec3[10](vec3(1.0, 0.0, 0.0), vec3(0.0), vec3(1.0, 0.6, 0.0), vec3(0.9, 0.2, 0.9), vec3(0.2, 0.5, 1.0),
             vec3(0.1, 0.9, 0.3), vec3(0.0, 0.9, 0.9), vec3(1.0, 1.0, 0.2), vec3(0.9, 0.2, 0.9), vec3(0.5, 0.6, 0.7));

/// Of radians a second to the right and down: red to the right, yellow-green up, cyan to the left, violet down; dark
/// where slow.
vec3 motion_colour(vec2 moves) {
    float hue = 6.0 * fract(atan(-moves.y, moves.x) / (2.0 * PI));
    vec3 full = clamp(abs(mod(hue + vec3(0.0, 4.0, 2.0), 6.0) - 3.0) - 1.0, 0.0, 1.0);
    return full * clamp(length(moves) / FULL_MOTION, 0.0, 1.0);
}

vec3 with_overlay(vec3 seen, ivec2 at, int eye) {
    if (overlay == OVERLAY_depth)
        return depth_scale > 0.0 ? depth_colour(depth_scale * texelFetch(eye_depth, ivec3(at, eye), 0).x) : 0.3 * seen;
    if (overlay == OVERLAY_gaps) {
        uint origin = texelFetch(origins, ivec3(at, eye), 0).x;
        return origin == ORIGIN_SOURCE ? 0.6 * seen : mix(seen, origin_colours[min(origin, 9u)], 0.7);
    }
    if (overlay == OVERLAY_reliability && has_reliability != 0) {
        float trusted = texelFetch(reliability, ivec3(at, eye), 0).x;
        return mix(vec3(1.0, 0.1, 0.1), seen, trusted);
    }
    if (overlay == OVERLAY_motion) {
        vec3 moves = has_motion != 0 ? texelFetch(motion, ivec3(at, eye), 0).xyz : vec3(0.0);
        vec3 grey = vec3(0.35 * dot(seen, vec3(0.2126, 0.7152, 0.0722)));
        return moves.z > 0.0 ? motion_colour(moves.xy) : grey;
    }
    return seen;
}

/// What an overlay's colours say, over a corner of the window.
vec3 with_legend(vec3 seen) {
    if (overlay != OVERLAY_motion || layout_shown == LAYOUT_sphere)
        return seen;
    vec2 up = (gl_FragCoord.xy - vec2(float(window_size.x) - LEGEND_PLACE.x, LEGEND_PLACE.y)) / LEGEND_RADIUS;
    float away = length(up);
    if (away > 1.0)
        return away < 1.06 ? vec3(0.9) : seen;
    return motion_colour(FULL_MOTION * vec2(up.x, -up.y));
}

vec3 eye_at(ivec2 at, int eye) {
    at = clamp(at, ivec2(0), eye_size - 1);
    bool others = gl_FragCoord.x > split * float(window_size.x);
    vec3 seen = others ? texelFetch(other_eyes, ivec3(at, eye), 0).rgb : texelFetch(eyes, ivec3(at, eye), 0).rgb;
    return others ? seen : with_overlay(seen, at, eye);
}

vec3 behind_lens(ivec2 at, int eye) {
    vec2 from_middle = (vec2(at) + 0.5 - 0.5 * vec2(eye_size)) / (0.5 * float(eye_size.x));
    float r2 = dot(from_middle, from_middle);
    vec2 bent = from_middle * (1.0 + r2 * (lens.x + r2 * lens.y)) / (1.0 + lens.x + lens.y);
    vec2 place = bent * 0.5 * float(eye_size.x) + 0.5 * vec2(eye_size);
    vec2 beyond = max(vec2(0.0), max(-place, place - vec2(eye_size)));
    vec2 low = floor(place - 0.5), weight = place - 0.5 - low;
    ivec2 first = ivec2(low);
    vec3 top = mix(eye_at(first, eye), eye_at(first + ivec2(1, 0), eye), weight.x);
    vec3 bottom = mix(eye_at(first + ivec2(0, 1), eye), eye_at(first + 1, eye), weight.x);
    return mix(top, bottom, weight.y) * clamp(1.0 - max(beyond.x, beyond.y) / 8.0, 0.0, 1.0);
}

/// The whole sphere, fitted into the window.
vec3 whole_sphere(ivec2 at) {
    vec2 size = vec2(textureSize(source, 0)), window = vec2(window_size);
    float scale = max(size.x / window.x, size.y / window.y);
    vec2 place = (vec2(at) + 0.5 - 0.5 * window) * scale + 0.5 * size;
    bool inside = all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, size));
    return inside ? texelFetch(source, ivec2(place), 0).rgb : vec3(0.08);
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.x, float(window_size.y) - gl_FragCoord.y);
    vec3 seen;
    if (layout_shown == LAYOUT_sphere) {
        seen = whole_sphere(at);
    } else if (layout_shown == LAYOUT_sbs || layout_shown == LAYOUT_headset) {
        int eye = at.x < window_size.x / 2 ? 0 : 1;
        ivec2 within = ivec2(at.x - eye * (window_size.x / 2), at.y);
        seen = layout_shown == LAYOUT_sbs ? eye_at(within, eye) : behind_lens(within, eye);
    } else if (layout_shown == LAYOUT_anaglyph) {
        seen = to_display(from_left * to_linear(eye_at(at, 0)) + from_right * to_linear(eye_at(at, 1)));
    } else {
        seen = eye_at(at, 0);
    }
    if (layout_shown != LAYOUT_sphere && split < 1.0 && abs(gl_FragCoord.x - split * float(window_size.x)) < 1.0)
        seen = vec3(1.0);
    float grey = dot(seen, vec3(0.2126, 0.7152, 0.0722));
    colour = vec4(with_legend(mix(seen, mix(vec3(grey), vec3(0.5), 0.6), fading)), 1.0);
}
)glsl";

class PlainDisplay {
public:
    PlainDisplay()
        : program_({{GL_VERTEX_SHADER, "display_vertex.glsl"}, {GL_FRAGMENT_SHADER, "plain", plain_display_text}},
                   defines()),
          nothing_(gl::make_layered_texture({1, 1}, 1, GL_R32F)) {
        GLuint name = 0;
        glCreateVertexArrays(1, &name);
        no_vertices_ = gl::VertexArray(name);
    }

    void draw(const gl::DisplayedPictures& pictures, const gl::DisplayOptions& options, gl::Size window) const {
        const gl::EyeTargets& other = pictures.other != nullptr ? *pictures.other : *pictures.eyes;
        const auto or_nothing = [this](GLuint texture) { return texture != 0 ? texture : nothing_.name(); };
        const std::array textures = {
            pictures.eyes->colour(),          pictures.eyes->origin(), or_nothing(pictures.depth.texture),
            or_nothing(pictures.reliability), other.colour(),          pictures.source->colour(),
            or_nothing(pictures.motion)};
        glBindTextures(0, GLsizei(textures.size()), textures.data());
        const gl::Size size = pictures.eyes->size();
        program_.set("layout_shown", int(options.layout));
        program_.set("overlay", int(options.overlay));
        program_.set("depth_scale", pictures.depth.texture != 0 ? pictures.depth.scale : 0.0f);
        program_.set("has_reliability", int(pictures.reliability != 0));
        program_.set("has_motion", int(pictures.motion != 0));
        program_.set("eye_size", glm::ivec2(size.width, size.height));
        program_.set("window_size", glm::ivec2(window.width, window.height));
        program_.set("from_left", options.anaglyph->from_left);
        program_.set("from_right", options.anaglyph->from_right);
        program_.set("lens", glm::vec3(options.lens.k1, options.lens.k2, 0));
        program_.set("fading", options.fading);
        program_.set("split", pictures.other != nullptr ? options.split : 1.0f);
        program_.use();
        glViewport(0, 0, window.width, window.height);
        glBindVertexArray(no_vertices_.name());
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }

private:
    static std::vector<std::string> defines() {
        std::vector<std::string> all;
        for (std::size_t i = 0; i < gl::display_layout_names.size(); ++i)
            all.push_back(formatted("LAYOUT_%s %zu", std::string(gl::display_layout_names[i]).c_str(), i));
        for (std::size_t i = 0; i < gl::overlay_names.size(); ++i)
            all.push_back(formatted("OVERLAY_%s %zu", std::string(gl::overlay_names[i]).c_str(), i));
        all.push_back(formatted("FULL_MOTION %.9g", gl::full_motion_deg_per_s * pi / 180));
        all.push_back(formatted("LEGEND_RADIUS %d.0", gl::motion_legend.radius));
        all.push_back(
            formatted("LEGEND_PLACE vec2(%d, %d)", gl::motion_legend.from_right, gl::motion_legend.from_bottom));
        return all;
    }

    gl::Program program_;
    gl::VertexArray no_vertices_;
    gl::Texture nothing_;
};

}  // namespace equistream::test
