#include "gl_peers.h"

#include <client/warp/eye_rays.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream::bench {

namespace {

constexpr std::string_view mesh_vertex = R"glsl(
layout(binding = 1) uniform sampler2D source_depth;
uniform int eye_number;
uniform ivec2 eye_size;
out vec2 sample_at;

#include "source_grid.glsl"
#include "eye_rays.glsl"

void main() {
    int columns = 2 * source_size.x;  // a row goes round twice: what is in view may lie across the seam
    ivec2 at = ivec2(gl_VertexID % columns, gl_VertexID / columns);
    EyeRays eye = eyes[eye_number];
    float sample_m = texelFetch(source_depth, wrapped(at), 0).x;
    vec3 point = direction_of(at) * min(sample_m, FAR_DISTANCE_M) - eye.eye.xyz;
    vec3 seen = transpose(mat3(eye.source_from_eye)) * point;
    vec2 pixel = vec2(seen.x, -seen.y) * eye.view.x + (eye.view.yz + 0.5) * -seen.z;
    const float near_m = 0.01;
    gl_Position = vec4(2.0 * pixel / vec2(eye_size) + seen.z, near_m, -seen.z);
    sample_at = (vec2(at) + 0.5) / vec2(source_size);
}
)glsl";

constexpr std::string_view mesh_fragment = R"glsl(
layout(binding = 0) uniform sampler2D source_colour;
in vec2 sample_at;
out vec4 colour;

void main() {
    colour = vec4(texture(source_colour, vec2(fract(sample_at.x), sample_at.y)).rgb, 1.0);
}
)glsl";

constexpr std::string_view search_fragment = R"glsl(
layout(binding = 0) uniform sampler2D source_colour;
layout(binding = 1) uniform sampler2D source_depth;
uniform int eye_number;
out vec4 colour;

#include "source_grid.glsl"
#include "eye_rays.glsl"

void main() {
    EyeRays eye = eyes[eye_number];
    vec3 ray = normalize(ray_of(eye, ivec2(gl_FragCoord.xy)));
    float along = dot(eye.eye.xyz, ray), off = dot(eye.eye.xyz, eye.eye.xyz);
    vec3 point = ray;
    vec2 position;
    float before = 0.0, t = 0.0;
    for (int i = 0; i < 8; ++i) {
        position = position_of(point) / vec2(source_size);
        float sample_m = min(textureLod(source_depth, position, 0.0).x, FAR_DISTANCE_M);
        before = t;
        // Where the ray is as far from the source's centre as the sample.
        t = sqrt(max(along * along - off + sample_m * sample_m, 0.0)) - along;
        point = eye.eye.xyz + t * ray;
    }
    bool settled = abs(t - before) < 0.02 * t;
    colour = settled ? vec4(textureLod(source_colour, position, 0.0).rgb, 1.0) : vec4(0.0);
}
)glsl";

gl::VertexArray vertex_array() {
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    return gl::VertexArray(name);
}

/// Colours between samples, and depths of the nearest.
void bind(const SourceView& source, const gl::SourceTextures& textures, std::span<const EyeView> eyes,
          gl::EyeBlocks& blocks) {
    blocks.set(source, eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks.name());
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        glTextureParameteri(textures.colour(), filter, GL_LINEAR);
    glBindTextureUnit(0, textures.colour());
    glBindTextureUnit(1, textures.depth());
}

/// As it was: others share the texture.
void unbind(const gl::SourceTextures& textures) {
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        glTextureParameteri(textures.colour(), filter, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

}  // namespace

PeerTargets::PeerTargets(const PerspectiveCamera& camera, int eyes)
    : size_{camera.width, camera.height}, colour_(gl::make_layered_texture(size_, eyes, GL_RGBA8)),
      depth_(gl::make_texture(size_, GL_DEPTH_COMPONENT32F)) {
    for (int i = 0; i < eyes; ++i) {
        GLuint name = 0;
        glCreateFramebuffers(1, &name);
        framebuffers_.emplace_back(name);
        glNamedFramebufferTextureLayer(name, GL_COLOR_ATTACHMENT0, colour_.name(), 0, i);
        glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth_.name(), 0);
        gl::require_complete(framebuffers_.back());
    }
}

void PeerTargets::begin(int eye) const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[std::size_t(eye)].name());
    glViewport(0, 0, size_.width, size_.height);
    constexpr std::array<float, 4> black{};
    constexpr float farthest = 0;
    glClearBufferfv(GL_COLOR, 0, black.data());
    glClearBufferfv(GL_DEPTH, 0, &farthest);
}

MeshWarp::MeshWarp(const EquirectCamera& sphere)
    : sphere_(sphere),
      program_({{GL_VERTEX_SHADER, "mesh warp", mesh_vertex}, {GL_FRAGMENT_SHADER, "mesh warp", mesh_fragment}}),
      vertices_(vertex_array()) {
    const int columns = 2 * sphere.width;
    std::vector<GLuint> strip;
    for (int x = 0; x < columns; ++x) {
        strip.push_back(GLuint(x));
        strip.push_back(GLuint(x + columns));
    }
    strip_ = gl::make_buffer_of(std::span<const GLuint>(strip));
    glVertexArrayElementBuffer(vertices_.name(), strip_.name());
}

void MeshWarp::find_rows(glm::vec3 ahead) {
    counts_.clear();
    offsets_.clear();
    first_vertices_.clear();
    // Half the diagonal of a view of 90 degrees, and eleven degrees for what parallax brings in.
    const double cos_reach = std::cos(pi / 3), around = std::hypot(ahead.x, ahead.z);
    const double middle = std::atan2(ahead.x, -ahead.z) / (2 * pi) + 0.5;
    for (int y = 0; y + 1 < sphere_.height; ++y) {
        const double latitude = pi * (0.5 - (y + 1.0) / sphere_.height);
        const double cosine = (cos_reach - std::sin(latitude) * double(ahead.y)) / (std::cos(latitude) * around);
        if (cosine >= 1)
            continue;
        const int half = int(std::ceil(std::acos(std::max(cosine, -1.0)) / (2 * pi) * sphere_.width));
        const int count = std::min(2 * half + 1, sphere_.width + 1);
        int first = int(middle * sphere_.width) - half;
        first += first < 0 ? sphere_.width : 0;
        first = std::min(first, 2 * sphere_.width - count);
        counts_.push_back(2 * count);
        offsets_.push_back(reinterpret_cast<const void*>(sizeof(GLuint) * 2 * std::size_t(first)));
        first_vertices_.push_back(2 * y * sphere_.width);
    }
}

void MeshWarp::draw(const SourceView& source, const gl::SourceTextures& textures, std::span<const EyeView> eyes,
                    const PeerTargets& targets) {
    bind(source, textures, eyes, blocks_);
    program_.use();
    glBindVertexArray(vertices_.name());
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        targets.begin(int(i));
        program_.set("eye_number", int(i));
        program_.set("eye_size", glm::ivec2(eyes[i].camera.width, eyes[i].camera.height));
        const EyeRays rays(eyes[i].camera, eyes[i].pose, source.pose);
        find_rows(rays.source_from_eye() * glm::vec3(0, 0, -1));
        glMultiDrawElementsBaseVertex(GL_TRIANGLE_STRIP, counts_.data(), GL_UNSIGNED_INT, offsets_.data(),
                                      GLsizei(counts_.size()), first_vertices_.data());
    }
    glDisable(GL_DEPTH_TEST);
    unbind(textures);
}

BackwardSearch::BackwardSearch()
    : program_({{GL_VERTEX_SHADER, "display_vertex.glsl"}, {GL_FRAGMENT_SHADER, "backward search", search_fragment}}),
      no_vertices_(vertex_array()) {}

void BackwardSearch::draw(const SourceView& source, const gl::SourceTextures& textures, std::span<const EyeView> eyes,
                          const PeerTargets& targets) {
    bind(source, textures, eyes, blocks_);
    program_.use();
    glBindVertexArray(no_vertices_.name());
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        targets.begin(int(i));
        program_.set("eye_number", int(i));
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    unbind(textures);
}

}  // namespace equistream::bench
