#include "file_sets.h"

#include <equistream/error.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <set>

namespace equistream::files {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t max_missing_named = 1000;

/// What is before and behind a number.
struct Pattern {
    fs::path folder;
    std::string before, behind;
    auto operator<=>(const Pattern&) const = default;
};

using Numbered = std::map<std::int64_t, fs::path>;

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/// The last run of digits before the extension is the frame's number; without one it is frame 0.
std::pair<Pattern, std::int64_t> parted(const fs::path& file) {
    const std::string name = file.filename().string();
    const std::size_t extension = std::min(name.rfind('.'), name.size());
    std::size_t end = extension;
    while (end > 0 && !is_digit(name[end - 1]))
        --end;
    std::size_t begin = end;
    while (begin > 0 && is_digit(name[begin - 1]) && end - begin < 9)
        --begin;
    if (begin == end)
        return {{file.parent_path(), name.substr(0, extension), name.substr(extension)}, 0};
    std::int64_t index = 0;
    std::from_chars(name.data() + begin, name.data() + end, index);
    return {{file.parent_path(), name.substr(0, begin), name.substr(end)}, index};
}

std::vector<fs::path> files_in(const fs::path& folder) {
    std::error_code error;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder, error))
        if (entry.path().extension() == ".exr" && entry.path().filename().string().front() != '.')
            files.push_back(entry.path());
    if (error)
        throw InputError(expected_found(folder.string(), "a folder of EXR files", error.message()));
    std::ranges::sort(files);
    return files;
}

void add_pattern(const fs::path& source, std::map<Pattern, Numbered>& sets) {
    const std::string name = source.filename().string();
    const std::size_t begin = name.find('#');
    std::size_t end = begin;
    while (end < name.size() && name[end] == '#')
        ++end;
    const fs::path folder = source.has_parent_path() ? source.parent_path() : fs::path(".");
    const Pattern pattern{folder, name.substr(0, begin), name.substr(end)};
    Numbered& frames = sets[pattern];
    for (const fs::path& file : files_in(folder)) {
        const std::string found = file.filename().string();
        if (!found.starts_with(pattern.before) || !found.ends_with(pattern.behind) ||
            found.size() <= pattern.before.size() + pattern.behind.size())
            continue;
        const char* first = found.data() + pattern.before.size();
        const char* last = found.data() + found.size() - pattern.behind.size();
        std::int64_t index = 0;
        if (const auto end_of_number = std::from_chars(first, last, index); end_of_number.ptr == last && index >= 0)
            frames[index] = file;
    }
    if (frames.empty())
        throw InputError(expected_found(source.string(), "files by this pattern", "none"));
}

/// Names without what they share: shot_beauty. and shot_depth. are beauty and depth.
std::vector<std::string> stems_of(const std::map<Pattern, Numbered>& sets) {
    std::vector<std::string> stems;
    for (const auto& [pattern, frames] : sets) {
        std::string stem = pattern.before;
        while (!stem.empty() && std::ispunct(static_cast<unsigned char>(stem.back())))
            stem.pop_back();
        const bool one_name =
            std::ranges::all_of(sets, [&](const auto& s) { return s.first.before == pattern.before; });
        // A folder for each AOV, else a name.
        stems.push_back(stem.empty() || (sets.size() > 1 && one_name) ? pattern.folder.filename().string() : stem);
    }
    std::size_t shared = stems.size() > 1 ? stems.front().size() : 0;
    for (const std::string& stem : stems) {
        std::size_t same = 0;
        while (same < std::min(shared, stem.size()) && stem[same] == stems.front()[same])
            ++same;
        shared = same;
    }
    while (shared > 0 && std::isalnum(static_cast<unsigned char>(stems.front()[shared - 1])))
        --shared;
    for (std::string& stem : stems)
        stem = stem.substr(shared);
    return stems;
}

}  // namespace

FileSets find_files(const std::vector<std::string>& sources) {
    std::map<Pattern, Numbered> sets;
    for (const std::string& source : sources) {
        std::vector<fs::path> files{source};
        if (fs::is_directory(source))
            files = files_in(source);
        else if (fs::path(source).filename().string().find('#') != std::string::npos) {
            add_pattern(source, sets);
            continue;
        } else if (!fs::exists(source))
            throw InputError(
                expected_found(source, "a folder, a file, or a pattern such as shot.####.exr", "no such file"));
        if (files.empty())
            throw InputError(expected_found(source, "EXR files", "none"));
        for (const fs::path& file : files) {
            const auto [pattern, index] = parted(file);
            sets[pattern][index] = file;
        }
    }
    FileSets found;
    found.stems = stems_of(sets);
    std::set<std::int64_t> indices;
    for (const auto& [pattern, frames] : sets)
        for (const auto& [index, file] : frames)
            indices.insert(index);
    for (const std::int64_t index : indices) {
        FileSets::Frame frame{index, {}};
        std::size_t set = 0;
        for (const auto& [pattern, frames] : sets) {
            if (const auto file = frames.find(index); file != frames.end())
                frame.files.push_back(file->second);
            else if (found.missing.size() < max_missing_named)
                found.missing.push_back({index, "frame " + std::to_string(index) + " of " + found.stems[set]});
            ++set;
        }
        if (frame.files.size() == sets.size())
            found.frames.push_back(std::move(frame));
    }
    for (auto index = indices.begin(); index != indices.end() && std::next(index) != indices.end(); ++index)
        for (std::int64_t gap = *index + 1; gap < *std::next(index) && found.missing.size() < max_missing_named; ++gap)
            found.missing.push_back({gap, "frame " + std::to_string(gap)});
    return found;
}

}  // namespace equistream::files
