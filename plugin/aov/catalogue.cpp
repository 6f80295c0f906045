#include <equistream/aov.h>
#include <equistream/error.h>

#include <algorithm>

namespace equistream {
namespace {

constexpr std::string_view colour_channels[] = {"R", "G", "B", "A"};
constexpr std::string_view albedo_channels[] = {"albedo.R", "albedo.G", "albedo.B"};
constexpr std::string_view depth_channels[] = {"depth.Z"};
constexpr std::string_view backward_channels[] = {"backward.u", "backward.v"};
constexpr std::string_view forward_channels[] = {"forward.u", "forward.v"};
constexpr std::string_view normal_channels[] = {"normal.X", "normal.Y", "normal.Z"};
constexpr std::string_view object_channels[] = {"object_id"};
constexpr std::string_view material_channels[] = {"material_id"};
constexpr std::string_view instance_channels[] = {"instance_id"};

constexpr AovInfo catalogue[] = {
    {"colour", "colour", colour_channels, SampleType::half, false, "radiance",
     "scene-referred linear Rec.709; A is the fraction of samples that hit a surface"},
    {"albedo", "albedo", albedo_channels, SampleType::half, false, "1",
     "diffuse albedo, specular colour of a metal; 0 for a miss"},
    {"depth", "depth", depth_channels, SampleType::real, true, "m",
     "distance from the camera's centre to the nearest surface along the pixel-centre ray; +inf for a miss"},
    {"backward", "motion", backward_channels, SampleType::real, true, "pixel",
     "from this pixel to where the point was in the previous frame"},
    {"forward", "motion", forward_channels, SampleType::real, true, "pixel",
     "from this pixel to where the point will be in the next frame"},
    {"normal", "normal", normal_channels, SampleType::real, true, "1",
     "world space, unit, facing the camera; 0 for a miss"},
    {"object_id", "ids", object_channels, SampleType::id, true, "", "from 1; 0 for a miss"},
    {"material_id", "ids", material_channels, SampleType::id, true, "", "from 1; 0 for a miss"},
    {"instance_id", "ids", instance_channels, SampleType::id, true, "", "from 1; 0 for a miss"},
};

/// "depth, motion, ..." as a user may type them.
std::string accepted_groups() {
    std::string text;
    std::string_view last;
    for (const AovInfo& aov : catalogue) {
        if (aov.group == "colour" || aov.group == last)
            continue;
        last = aov.group;
        text += std::string(aov.group) + ", ";
    }
    return text + "all or none";
}

bool is_group(std::string_view word) {
    return std::any_of(std::begin(catalogue), std::end(catalogue), [&](const AovInfo& a) { return a.group == word; });
}

std::string_view trimmed(std::string_view word) {
    const auto first = word.find_first_not_of(' ');
    if (first == std::string_view::npos)
        return {};
    return word.substr(first, word.find_last_not_of(' ') - first + 1);
}

}  // namespace

std::span<const AovInfo> aov_catalogue() {
    return catalogue;
}

std::optional<AovInfo> find_aov(std::string_view name) {
    for (const AovInfo& aov : catalogue)
        if (aov.name == name)
            return aov;
    return std::nullopt;
}

std::vector<std::string> parse_aov_groups(std::string_view list) {
    std::vector<std::string_view> wanted{"colour"};
    const bool none = trimmed(list) == "none";
    for (std::size_t begin = 0; !none && begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        const std::string_view word = trimmed(list.substr(begin, end - begin));
        if (word == "all")
            for (const AovInfo& aov : catalogue)
                wanted.push_back(aov.group);
        else if (is_group(word))
            wanted.push_back(word);
        else
            throw InputError(expected_found("aovs", accepted_groups(), "\"" + std::string(word) + "\""));
        begin = end + 1;
    }
    std::vector<std::string> planes;
    for (const AovInfo& aov : catalogue)
        if (std::find(wanted.begin(), wanted.end(), aov.group) != wanted.end())
            planes.emplace_back(aov.name);
    return planes;
}

}  // namespace equistream
