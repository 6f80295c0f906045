#include "display.h"

#include <equistream/conventions.h>
#include <equistream/text.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

namespace equistream::gl {

namespace {

constexpr Size one_texel{1, 1};
/// Where no column is near it.
constexpr float no_line = -2;
/// Of the legend's radius.
constexpr double legend_rim = 1.06;

/// SHOWN of display.glsl.
enum class Shown { eye, anaglyph, lens, sphere };
constexpr std::array<std::string_view, 4> shown_names = {"eye", "anaglyph", "lens", "sphere"};

void define(std::vector<std::string>& all, const char* kind, std::span<const std::string_view> names) {
    for (std::size_t i = 0; i < names.size(); ++i)
        all.push_back(formatted("%s_%.*s %zu", kind, int(names[i].size()), names[i].data(), i));
}

std::string in_glsl(const OverlayColour& colour) {
    return formatted("vec3(%.9g, %.9g, %.9g)", double(colour.red), double(colour.green), double(colour.blue));
}

void define_colours(std::vector<std::string>& all) {
    constexpr std::array depth_names = {"DEPTH_FAR", "DEPTH_MIDDLE", "DEPTH_NEAR"};
    for (std::size_t i = 0; i < depth_names.size(); ++i)
        all.push_back(std::string(depth_names[i]) + " " + in_glsl(depth_colours[i]));
    all.push_back(formatted("HALF_DEPTH %.9g", double(half_depth_m)));
    std::string origins;
    for (const OverlayColour& colour : origin_colours)
        origins += (origins.empty() ? "" : ", ") + in_glsl(colour);
    all.push_back(formatted("ORIGIN_COLOURS vec3[%zu](%s)", origin_colours.size(), origins.c_str()));
    all.push_back("UNRELIABLE " + in_glsl(unreliable_colour));
}

Program make_program(std::string_view fragments, Shown shown = Shown::eye, Overlay overlay = Overlay::none) {
    std::vector<std::string> all;
    define(all, "SHOWN", shown_names);
    define(all, "OVERLAY", overlay_names);
    define_colours(all);
    all.push_back(formatted("SHOWN %d", int(shown)));
    all.push_back(formatted("OVERLAY %d", int(overlay)));
    all.push_back(formatted("FULL_MOTION %.9g", full_motion_deg_per_s * pi / 180));
    all.push_back(formatted("LEGEND_RADIUS %d.0", motion_legend.radius));
    all.push_back(formatted("LEGEND_RIM %.9g", legend_rim));
    return Program({{GL_VERTEX_SHADER, "display_vertex.glsl"}, {GL_FRAGMENT_SHADER, fragments}}, all);
}

/// What a layout shows, by DisplayLayout.
struct LayoutRow {
    Shown shown;
    int eyes;
    bool has_halves;
};
constexpr std::array<LayoutRow, display_layout_names.size()> layouts = {{{Shown::eye, 1, false},
                                                                         {Shown::eye, 1, false},
                                                                         {Shown::eye, 2, true},
                                                                         {Shown::anaglyph, 2, false},
                                                                         {Shown::lens, 2, true},
                                                                         {Shown::sphere, 1, false}}};

const LayoutRow& row_of(DisplayLayout layout) {
    return layouts[std::size_t(layout)];
}

/// Where reliability is not known the picture stays as it is.
Overlay overlay_of(const DisplayedPictures& pictures, Overlay overlay) {
    return overlay == Overlay::reliability && pictures.reliability == 0 ? Overlay::none : overlay;
}

}  // namespace

int eyes_of(DisplayLayout layout) {
    return row_of(layout).eyes;
}

Size eye_size(DisplayLayout layout, Size window) {
    return {std::max(1, row_of(layout).has_halves ? window.width / 2 : window.width), std::max(1, window.height)};
}

std::optional<ShownPixel> shown_pixel(DisplayLayout layout, Size window, int x, int y) {
    const LayoutRow& row = row_of(layout);
    if (row.shown == Shown::lens || row.shown == Shown::sphere || x < 0 || y < 0 || x >= window.width ||
        y >= window.height)
        return std::nullopt;
    const int middle = row.has_halves ? window.width / 2 : window.width, eye = x < middle ? 0 : 1;
    const Size size = eye_size(layout, window);
    return ShownPixel{eye, std::min(x - eye * middle, size.width - 1), std::min(y, size.height - 1)};
}

Display::Display()
    : sphere_(make_program("display.glsl", Shown::sphere)), legend_(make_program("display_legend.glsl")),
      nothing_(make_layered_texture(one_texel, 1, GL_R32F)) {
    for (const Shown shown : {Shown::eye, Shown::anaglyph, Shown::lens})
        for (std::size_t overlay = 0; overlay < overlay_names.size(); ++overlay)
            eyes_.push_back(make_program("display.glsl", shown, Overlay(overlay)));
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    no_vertices_ = VertexArray(name);
}

void Display::cover(const Program& program, Box box) const {
    program.use();
    glScissor(box.left, box.bottom, box.width, box.height);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Display::draw_sphere(const SourceTextures& source, float fading, Size window) const {
    glBindTextureUnit(3, source.colour());
    sphere_.set("window_size", glm::ivec2(window.width, window.height));
    sphere_.set("fading", fading);
    sphere_.set("line", no_line);
    cover(sphere_, {0, 0, window.width, window.height});
}

void Display::draw_eyes(const DisplayedPictures& pictures, const DisplayOptions& options, Columns columns,
                        Size window) const {
    const EyeTargets& eyes = *pictures.eyes;
    const Shown shown = row_of(options.layout).shown;
    const Overlay overlay = overlay_of(pictures, options.overlay);
    const Program& program = eyes_[std::size_t(shown) * overlay_names.size() + std::size_t(overlay)];
    const GLuint overlaid = overlay == Overlay::depth         ? pictures.depth.texture
                            : overlay == Overlay::reliability ? pictures.reliability
                            : overlay == Overlay::motion      ? pictures.motion
                                                              : 0;
    const std::array textures = {eyes.colour(), overlaid != 0 ? overlaid : nothing_.name(), eyes.origin()};
    glBindTextures(0, GLsizei(textures.size()), textures.data());
    const Size size = eyes.size();
    program.set("window_size", glm::ivec2(window.width, window.height));
    program.set("eye_size", glm::ivec2(size.width, size.height));
    program.set("fading", options.fading);
    program.set("line", options.split < 1 ? options.split * float(window.width) : no_line);
    if (overlay == Overlay::depth)
        program.set("depth_scale", overlaid != 0 ? pictures.depth.scale : 0.0f);
    if (overlay == Overlay::motion)
        program.set("has_motion", int(overlaid != 0));
    if (shown == Shown::anaglyph) {
        program.set("from_left", options.anaglyph->from_left);
        program.set("from_right", options.anaglyph->from_right);
    } else {
        program.set("middle", row_of(options.layout).has_halves ? window.width / 2 : window.width);
    }
    if (shown == Shown::lens)
        program.set("lens", glm::vec3(options.lens.k1, options.lens.k2, 0));
    cover(program, {columns.begin, 0, columns.end - columns.begin, window.height});
}

void Display::draw_legend(Size window) const {
    const int from_middle = int(std::ceil(legend_rim * motion_legend.radius));
    const int x = window.width - motion_legend.from_right, y = motion_legend.from_bottom;
    legend_.set("middle", glm::vec2(x, y));
    cover(legend_, {x - from_middle, y - from_middle, 2 * from_middle, 2 * from_middle});
}

void Display::draw(const DisplayedPictures& pictures, const DisplayOptions& options, Size window) const {
    for (const GLenum off : {GL_DEPTH_TEST, GL_BLEND, GL_CULL_FACE})
        glDisable(off);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glViewport(0, 0, window.width, window.height);
    glBindVertexArray(no_vertices_.name());
    glEnable(GL_SCISSOR_TEST);
    if (options.layout == DisplayLayout::sphere) {
        draw_sphere(*pictures.source, options.fading, window);
    } else {
        DisplayOptions shown = options;
        if (pictures.other == nullptr)
            shown.split = 1;
        // Pixels whose middle is right of the split show the other.
        const int first_other =
            shown.split < 1 ? std::clamp(int(std::floor(shown.split * float(window.width) + 0.5f)), 0, window.width)
                            : window.width;
        draw_eyes(pictures, shown, {0, first_other}, window);
        if (first_other < window.width) {
            shown.overlay = Overlay::none;
            draw_eyes({.eyes = pictures.other}, shown, {first_other, window.width}, window);
        }
        if (options.overlay == Overlay::motion)
            draw_legend(window);
    }
    glDisable(GL_SCISSOR_TEST);
}

}  // namespace equistream::gl
