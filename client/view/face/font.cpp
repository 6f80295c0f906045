#include "font.h"

#include <fontconfig/fontconfig.h>
#include <imgui.h>
#include <imgui_freetype.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <vector>

namespace equistream {

namespace {

/// Latin, Greek and Cyrillic, which names of files have, and dashes and quotes.
constexpr std::array<ImWchar, 9> letters = {0x20, 0x24f, 0x370, 0x3ff, 0x400, 0x52f, 0x2010, 0x2027, 0};
/// No font of ours is near it.
constexpr std::size_t max_font_bytes = std::size_t{64} << 20;

template <auto free>
struct Freed {
    template <typename T>
    void operator()(T* object) const {
        free(object);
    }
};

std::vector<char> read_all(const std::string& file) {
    std::ifstream stream(file, std::ios::binary | std::ios::ate);
    const std::streamoff bytes = stream ? std::streamoff(stream.tellg()) : 0;
    if (bytes <= 0 || std::size_t(bytes) > max_font_bytes)
        return {};
    std::vector<char> content(static_cast<std::size_t>(bytes));
    stream.seekg(0);
    stream.read(content.data(), bytes);
    return stream ? content : std::vector<char>();
}

}  // namespace

int font_height_px(double scale) {
    return int(std::lround(line_height_px * std::clamp(scale, 0.5, 8.0)));
}

FontFile find_font() {
    const std::unique_ptr<FcConfig, Freed<FcConfigDestroy>> config(FcInitLoadConfigAndFonts());
    const std::unique_ptr<FcPattern, Freed<FcPatternDestroy>> wanted(
        FcNameParse(reinterpret_cast<const FcChar8*>("DejaVu Sans,sans-serif:scalable=true")));
    if (!config || !wanted)
        return {};
    FcConfigSubstitute(config.get(), wanted.get(), FcMatchPattern);
    FcDefaultSubstitute(wanted.get());
    FcResult result = FcResultNoMatch;
    const std::unique_ptr<FcPattern, Freed<FcPatternDestroy>> found(FcFontMatch(config.get(), wanted.get(), &result));
    FontFile font;
    FcChar8* file = nullptr;
    if (found && FcPatternGetString(found.get(), FC_FILE, 0, &file) == FcResultMatch)
        font.file = reinterpret_cast<const char*>(file);
    if (found)
        FcPatternGetInteger(found.get(), FC_INDEX, 0, &font.index);
    font.index &= 0xffff;  // above that: a named instance of a variable font
    return font;
}

void load_font(ImFontAtlas& atlas, const FontFile& font, int height_px) {
    const std::vector<char> content = font.file.empty() ? std::vector<char>() : read_all(font.file);
    atlas.Clear();
    atlas.FontBuilderIO = ImGuiFreeType::GetBuilderForFreeType();
    if (!content.empty()) {
        ImFontConfig config;
        config.FontNo = font.index;
        void* const copy = ImGui::MemAlloc(content.size());  // the atlas frees it
        std::memcpy(copy, content.data(), content.size());
        atlas.AddFontFromMemoryTTF(copy, int(content.size()), float(height_px), &config, letters.data());
        if (atlas.Build())
            return;
        atlas.Clear();
    }
    // Pictures of 13 rows, which lose strokes at any scale but whole ones.
    constexpr int rows = 13;
    ImFontConfig config;
    config.SizePixels = float(rows * std::max(1, height_px / rows));
    atlas.AddFontDefault(&config);
    atlas.Build();
}

}  // namespace equistream
