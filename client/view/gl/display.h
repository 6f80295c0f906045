#pragma once
/// From both eyes' pictures to what a display shows: one eye, both side by side, through coloured glasses, behind a
/// headset's lenses, or the sphere itself; with an overlay of what is known of the pixels, and beside another way to
/// draw the same. One triangle over the framebuffer that is bound.
#include <client/gpu/program.h>
#include <client/warp/gl/eye_targets.h>
#include <client/warp/gl/source_textures.h>

#include <client/view/stereo_layout.h>

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace equistream::gl {

enum class DisplayLayout { left, right, side_by_side, anaglyph, headset, sphere };
inline constexpr std::array<std::string_view, 6> display_layout_names = {"left",     "right",   "sbs",
                                                                         "anaglyph", "headset", "sphere"};

enum class Overlay { none, depth, gaps, reliability, motion };
inline constexpr std::array<std::string_view, 5> overlay_names = {"none", "depth", "gaps", "reliability", "motion"};

struct OverlayColour {
    float red, green, blue;
};
/// The overlay of depth: a place on a line from far (0) over the middle (0.5) to near (1), of half_depth_m / (that +
/// z).
inline constexpr std::array<OverlayColour, 3> depth_colours = {
    {{0.1f, 0.2f, 0.6f}, {0.1f, 0.8f, 0.5f}, {1, 0.75f, 0.1f}}};
inline constexpr float half_depth_m = 4;
/// The overlay of gaps: who coloured a pixel, by PixelOrigin; what the main picture shows is darkened.
inline constexpr std::array<OverlayColour, pixel_origin_count> origin_colours = {{{1, 0, 0},
                                                                                  {0, 0, 0},
                                                                                  {1, 0.6f, 0},
                                                                                  {0.9f, 0.2f, 0.9f},
                                                                                  {0.2f, 0.5f, 1},
                                                                                  {0.1f, 0.9f, 0.3f},
                                                                                  {0, 0.9f, 0.9f},
                                                                                  {1, 1, 0.2f},
                                                                                  {0.9f, 0.2f, 0.9f},
                                                                                  {0.5f, 0.6f, 0.7f}}};
/// The same in words.
inline constexpr std::array<std::string_view, pixel_origin_count> origin_words = {
    "still a gap", "the main picture", "the small second view", "its neighbours",      "an earlier frame",
    "patches",     "the hidden layer", "the scene's geometry",  "invented (pushpull)", "the coarse sphere (base)"};
/// The overlay of reliability: from this colour, where nothing can be trusted, to the picture's own.
inline constexpr OverlayColour unreliable_colour{1, 0.1f, 0.1f};

/// The overlay of motion: direction by hue, speed by brightness, which is full from here on.
inline constexpr double full_motion_deg_per_s = 60;
/// Its legend, a disc in which each place has the colour of what moves from the middle that way: radius, and how far
/// its middle is from the window's right border and from the lower one, in pixels.
struct MotionLegend {
    int radius = 44, from_right = 64, from_bottom = 128;
};
inline constexpr MotionLegend motion_legend;

/// How a lens bends: a display's point at r focal lengths from a lens' middle shows the direction of tangent
/// r (1 + k1 r^2 + k2 r^4). The values are an example of a headset of some 100 degrees, not a product's.
struct Lens {
    float k1 = 0.22f, k2 = 0.24f;
};

struct DisplayOptions {
    DisplayLayout layout = DisplayLayout::left;
    const Anaglyph* anaglyph = &anaglyphs().front();
    Overlay overlay = Overlay::none;
    Lens lens{};
    float fading = 0;  ///< 0 to 1: how far the picture goes to grey, outside the head box
    /// Columns of the window, 0 to 1, from which on `other` is shown; 1: nowhere.
    float split = 1;
};

/// Of both eyes, or of one where the layout shows one (layer 0); the sphere needs `source` alone.
struct DisplayedPictures {
    const EyeTargets* eyes = nullptr;
    const EyeTargets* other = nullptr;  ///< of the same size; null: there is no split
    EyeDepth depth{};                   ///< texture 0: not known
    GLuint reliability = 0;             ///< see ReliabilityMap; 0: not known
    GLuint motion = 0;                  ///< see MotionView; 0: nothing is said to move
    const SourceTextures* source = nullptr;
};

/// How many eyes a layout shows, and how large a picture each needs of a window.
int eyes_of(DisplayLayout layout);
Size eye_size(DisplayLayout layout, Size window);

/// Which pixel of which eye a place of the window shows, both from the upper left corner. Nothing where it shows none,
/// or one that a lens has bent; through coloured glasses the left eye's.
struct ShownPixel {
    int eye = 0;  ///< of the layout's
    int x = 0, y = 0;

    bool operator==(const ShownPixel&) const = default;
};
std::optional<ShownPixel> shown_pixel(DisplayLayout layout, Size window, int x, int y);

/// Programs for everything that may be shown are made when it is.
class Display {
public:
    Display();

    /// Covers the whole of a framebuffer of that size.
    void draw(const DisplayedPictures& pictures, const DisplayOptions& options, Size window) const;

private:
    /// Of the window, in pixels.
    struct Columns {
        int begin, end;
    };
    struct Box {
        int left, bottom, width, height;
    };

    void draw_sphere(const SourceTextures& source, float fading, Size window) const;
    void draw_eyes(const DisplayedPictures& pictures, const DisplayOptions& options, Columns columns,
                   Size window) const;
    void draw_legend(Size window) const;
    void cover(const Program& program, Box box) const;

    std::vector<Program> eyes_;  ///< one, through coloured glasses, behind a lens: each under each overlay
    Program sphere_, legend_;
    VertexArray no_vertices_;
    Texture nothing_;  ///< stands where a picture is missing
};

}  // namespace equistream::gl
