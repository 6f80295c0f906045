#pragma once
/// The letters of the viewer's panels: the system's sans serif, drawn at whatever size the display asks for.
#include <string>

struct ImFontAtlas;

namespace equistream {

/// Height of a line of text where the display has 96 dots per inch, pixels.
inline constexpr double line_height_px = 15;
/// That of a display: whole pixels, for letters are drawn once and then copied.
int font_height_px(double scale);

struct FontFile {
    std::string file;  ///< empty: fontconfig knows none
    int index = 0;     ///< of several in one file
};
/// What fontconfig takes for sans serif.
FontFile find_font();

/// Fills an atlas with the letters of that font, of this height; with Dear ImGui's own bitmap letters where there is no
/// font, or it cannot be read.
void load_font(ImFontAtlas& atlas, const FontFile& font, int height_px);

}  // namespace equistream
