#include "display.h"

#include <equistream/conventions.h>
#include <equistream/formatted.h>

#include <array>
#include <cassert>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

constexpr Size one_texel{1, 1};

std::vector<std::string> defines() {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < display_layout_names.size(); ++i)
        all.push_back(
            formatted("LAYOUT_%.*s %zu", int(display_layout_names[i].size()), display_layout_names[i].data(), i));
    for (std::size_t i = 0; i < overlay_names.size(); ++i)
        all.push_back(formatted("OVERLAY_%.*s %zu", int(overlay_names[i].size()), overlay_names[i].data(), i));
    all.push_back(formatted("FULL_MOTION %.9g", full_motion_deg_per_s * pi / 180));
    all.push_back(formatted("LEGEND_RADIUS %d.0", motion_legend.radius));
    all.push_back(formatted("LEGEND_PLACE vec2(%d, %d)", motion_legend.from_right, motion_legend.from_bottom));
    return all;
}

}  // namespace

int eyes_of(DisplayLayout layout) {
    switch (layout) {
    case DisplayLayout::left:
    case DisplayLayout::right:
    case DisplayLayout::sphere:
        return 1;
    case DisplayLayout::side_by_side:
    case DisplayLayout::anaglyph:
    case DisplayLayout::headset:
        break;
    }
    return 2;
}

Size eye_size(DisplayLayout layout, Size window) {
    const bool halves = layout == DisplayLayout::side_by_side || layout == DisplayLayout::headset;
    return {std::max(1, halves ? window.width / 2 : window.width), std::max(1, window.height)};
}

Display::Display()
    : program_({{GL_VERTEX_SHADER, "display_vertex.glsl"}, {GL_FRAGMENT_SHADER, "display.glsl"}}, defines()),
      nothing_(make_layered_texture(one_texel, 1, GL_R32F)), nothing_known_(make_texture(one_texel, GL_RGBA8)) {
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    no_vertices_ = VertexArray(name);
}

void Display::draw(const DisplayedPictures& pictures, const DisplayOptions& options, Size window) const {
    assert(pictures.eyes != nullptr);
    const EyeTargets& other = pictures.other != nullptr ? *pictures.other : *pictures.eyes;
    const auto or_nothing = [this](GLuint texture) { return texture != 0 ? texture : nothing_.name(); };
    const std::array textures = {pictures.eyes->colour(),
                                 pictures.eyes->origin(),
                                 or_nothing(pictures.depth.texture),
                                 or_nothing(pictures.reliability),
                                 other.colour(),
                                 pictures.source != nullptr ? pictures.source->colour() : nothing_known_.name(),
                                 or_nothing(pictures.motion)};
    glBindTextures(0, GLsizei(textures.size()), textures.data());
    const Size size = pictures.eyes->size();
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
    for (const GLenum off : {GL_DEPTH_TEST, GL_BLEND, GL_CULL_FACE, GL_SCISSOR_TEST})
        glDisable(off);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glViewport(0, 0, window.width, window.height);
    glBindVertexArray(no_vertices_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace equistream::gl
