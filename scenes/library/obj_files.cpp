#include "obj_files.h"

#include "file_bytes.h"

#include <equistream/error.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
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
    static constexpr Option options[] = {{"-blendu", 1}, {"-blendv", 1},     {"-boost", 1},   {"-bm", 1},  {"-cc", 1},
                                         {"-clamp", 1},  {"-colorspace", 1}, {"-imfchan", 1}, {"-mm", 2},  {"-o", 3},
                                         {"-s", 3},      {"-t", 3},          {"-texres", 1},  {"-type", 1}};
    const ObjLine line{0, {}, statement};
    ObjTexture texture;
    for (std::size_t at = 0;;) {
        const std::size_t before = at;
        const std::string_view word = line.next_word(at);
        const auto option =
            std::find_if(std::begin(options), std::end(options), [&](const Option& o) { return o.name == word; });
        if (option == std::end(options)) {
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
            if (!number || i >= 2 || (word != "-s" && word != "-o"))
                continue;
            if (const auto single = static_cast<float>(*number); std::isfinite(single))
                (word == "-s" ? texture.scale : texture.offset)[i] = single;
            else
                texture.is_beyond = true;
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

namespace {

constexpr std::uintmax_t file_size_limit = 0xffffffff;
constexpr std::size_t line_size_limit = 1 << 20;
constexpr std::string_view blanks = " \t\v\f";

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos)
        return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

}  // namespace

std::string_view ObjLine::next_word(std::size_t& at) const {
    const std::string_view text = rest;
    const std::size_t first = std::min(text.find_first_not_of(blanks, at), text.size());
    const std::size_t end = std::min(text.find_first_of(blanks, first), text.size());
    at = end;
    return text.substr(first, end - first);
}

ObjLines::ObjLines(const std::filesystem::path& file, const std::string& what)
    : file_(file.string()), stream_(open_regular_file(file, what)) {
    std::error_code error;
    if (const std::uintmax_t size = std::filesystem::file_size(file, error); size > file_size_limit)
        throw InputError(expected_found(file_, "a " + what + " below 4 GiB", std::to_string(size) + " bytes"));
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    char start[3] = {};
    stream_.read(start, 3);
    stream_.clear();
    if (std::string_view(start, 3) != byte_order_mark)
        stream_.seekg(0);
}

bool ObjLines::read_physical(std::string& line) {
    std::streambuf& bytes = *stream_.rdbuf();
    constexpr int end = std::char_traits<char>::eof();
    int c = bytes.sbumpc();
    if (c == end)
        return false;
    ++read_;
    for (; c != end && c != '\n' && c != '\r'; c = bytes.sbumpc()) {
        if (c == 0)
            throw InputError(expected_found(where(read_), "text", "a zero byte"));
        if (line.size() >= line_size_limit)
            throw InputError(expected_found(where(read_), "a line below 1 MiB", "a longer one"));
        line += static_cast<char>(c);
    }
    if (c == '\r' && bytes.sgetc() == '\n')
        bytes.sbumpc();
    return true;
}

/// `text` ends without blanks. Blanks before a joint are looked at once, however many lines are joined.
void ObjLines::join_continued(std::string& text, std::size_t begin) {
    std::size_t joint = begin, solid_before = begin, solid = text.size();  // past the last character that is no blank
    const auto solid_since_joint = [&] {
        const std::size_t last = std::string_view(text).substr(joint).find_last_not_of(blanks);
        return last == std::string_view::npos ? solid_before : joint + last + 1;
    };
    while (solid > begin && text[solid - 1] == '\\') {
        text.resize(solid - 1);
        if (joint > text.size())
            joint = solid_before = begin;
        solid_before = solid_since_joint();
        text += ' ';
        joint = text.size();
        if (!read_physical(text))
            return;
        solid = solid_since_joint();
    }
}

std::optional<ObjLine> ObjLines::next() {
    for (;;) {
        std::string text;
        if (!read_physical(text))
            return std::nullopt;
        ObjLine line;
        line.number = read_;
        std::string_view statement = trimmed(text);
        if (statement.empty() || statement.front() == '#')
            continue;
        const auto begin = static_cast<std::size_t>(statement.data() - text.data());
        text.resize(begin + statement.size());
        join_continued(text, begin);
        statement = trimmed(std::string_view(text).substr(begin));
        const std::size_t end = std::min(statement.find_first_of(blanks), statement.size());
        line.keyword = statement.substr(0, end);
        line.rest = trimmed(statement.substr(end));
        if (!line.keyword.empty())
            return line;
    }
}

std::optional<double> obj_number(std::string_view word) {
    if (word.starts_with('+'))
        word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || word.empty() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

}  // namespace equistream
