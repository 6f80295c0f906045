#include "obj_files.h"

#include "obj_lines.h"

#include <algorithm>
#include <array>
#include <set>

namespace equistream {

namespace fs = std::filesystem;

namespace {

std::string lower_case(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z')
            c = static_cast<char>(c - 'A' + 'a');
    return text;
}

std::string utf8_from_latin1(const std::string& text) {
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80) {
            out += c;
        } else {
            out += static_cast<char>(0xc0 | (byte >> 6));
            out += static_cast<char>(0x80 | (byte & 0x3f));
        }
    }
    return out;
}

/// One component of a path in any case; the first in order of names, so that every machine finds the same.
std::optional<fs::path> find_entry(const fs::path& folder, const std::string& name) {
    std::error_code error;
    if (fs::exists(folder / name, error))
        return folder / name;
    const std::string wanted = lower_case(name);
    std::optional<fs::path> found;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
        if (lower_case(entry->path().filename().string()) == wanted && (!found || entry->path() < *found))
            found = entry->path();
    return found;
}

std::optional<fs::path> find_in_any_case(const fs::path& folder, const fs::path& name) {
    std::error_code error;
    const fs::path as_written = folder / name;
    if (fs::is_regular_file(as_written, error))
        return as_written;
    std::optional<fs::path> at = name.is_absolute() ? name.root_path() : folder.empty() ? fs::path(".") : folder;
    for (const fs::path& part : name.relative_path()) {
        if (part.empty() || part == ".")
            continue;
        at = find_entry(*at, part.string());
        if (!at)
            return std::nullopt;
    }
    return fs::is_regular_file(*at, error) ? at : std::nullopt;
}

bool is_texture_keyword(const std::string& keyword) {
    static constexpr std::array others = {"bump", "disp", "decal", "refl", "norm"};
    const std::string lower = lower_case(keyword);
    return lower.starts_with("map_") || std::find(others.begin(), others.end(), lower) != others.end();
}

void add_images(const fs::path& material_file, std::set<fs::path>& files) {
    ObjLines lines(material_file, "material file (MTL)");
    while (const auto line = lines.next())
        if (is_texture_keyword(line->keyword))
            if (const auto file = find_named_file(material_file.parent_path(), parse_texture(line->rest).name))
                files.insert(*file);
}

}  // namespace

bool is_obj(const fs::path& model) {
    return lower_case(model.extension().string()) == ".obj";
}

std::optional<fs::path> find_named_file(const fs::path& folder, const std::string& name) {
    std::string slashed = name;
    std::replace(slashed.begin(), slashed.end(), '\\', '/');
    if (slashed.size() >= 2 && slashed.front() == '"' && slashed.back() == '"')
        slashed = slashed.substr(1, slashed.size() - 2);
    if (slashed.empty() || slashed.size() > 4096)
        return std::nullopt;
    for (const std::string& text : {slashed, utf8_from_latin1(slashed)})
        for (const fs::path& path : {fs::path(text), fs::path(text).filename()})
            if (!path.empty())
                if (auto file = find_in_any_case(folder, path))
                    return file;
    return std::nullopt;
}

std::vector<fs::path> find_material_files(const fs::path& folder, const std::string& names) {
    if (const auto file = find_named_file(folder, names))
        return {*file};
    std::vector<fs::path> files;
    const ObjLine line{0, {}, names};
    for (std::size_t at = 0; at < names.size();)
        if (const auto file = find_named_file(folder, std::string(line.next_word(at))))
            files.push_back(*file);
    return files;
}

ObjTexture parse_texture(const std::string& statement) {
    struct Option {
        std::string_view name;
        int words;  // after it, at most; beyond the first only numbers
    };
    static constexpr std::array<Option, 14> options = {{{"-blendu", 1},
                                                        {"-blendv", 1},
                                                        {"-boost", 1},
                                                        {"-bm", 1},
                                                        {"-cc", 1},
                                                        {"-clamp", 1},
                                                        {"-colorspace", 1},
                                                        {"-imfchan", 1},
                                                        {"-mm", 2},
                                                        {"-o", 3},
                                                        {"-s", 3},
                                                        {"-t", 3},
                                                        {"-texres", 1},
                                                        {"-type", 1}}};
    const ObjLine line{0, {}, statement};
    ObjTexture texture;
    for (std::size_t at = 0;;) {
        const std::size_t before = at;
        const std::string_view word = line.next_word(at);
        const auto option =
            std::find_if(options.begin(), options.end(), [&](const Option& o) { return o.name == word; });
        if (option == options.end()) {
            const std::size_t start = std::min(line.rest.find_first_not_of(" \t", before), line.rest.size());
            texture.name = line.rest.substr(start);
            return texture;
        }
        for (int i = 0; i < option->words; ++i) {
            std::size_t after = at;
            const std::string_view value = line.next_word(after);
            const auto number = obj_number(value);
            if (i > 0 && !number)
                break;
            at = after;
            if (word == "-clamp")
                texture.clamp = value == "on";
            if (number && i < 2 && word == "-s")
                texture.scale[i] = static_cast<float>(*number);
            if (number && i < 2 && word == "-o")
                texture.offset[i] = static_cast<float>(*number);
        }
    }
}

std::vector<fs::path> files_of_obj(const fs::path& model) {
    std::set<fs::path> materials, files;
    ObjLines lines(model, "model");
    while (const auto line = lines.next())
        if (line->keyword == "mtllib")
            for (const fs::path& file : find_material_files(model.parent_path(), line->rest))
                materials.insert(file);
    files = materials;
    for (const fs::path& file : materials)
        add_images(file, files);
    return {files.begin(), files.end()};
}

}  // namespace equistream
