#include <equistream/aov.h>
#include <equistream/aov_groups.h>
#include <equistream/error.h>

#include <algorithm>

namespace equistream {
namespace {

/// "depth, motion, ..." as a user may type them.
std::string accepted_groups() {
    std::string text;
    std::string_view last;
    for (const AovInfo& aov : aov_catalogue()) {
        if (aov.group == "colour" || aov.group == last)
            continue;
        last = aov.group;
        text += std::string(aov.group) + ", ";
    }
    return text + "all or none";
}

bool is_group(std::string_view word) {
    return std::ranges::any_of(aov_catalogue(), [&](const AovInfo& a) { return a.group == word; });
}

std::string_view trimmed(std::string_view word) {
    const auto first = word.find_first_not_of(' ');
    if (first == std::string_view::npos)
        return {};
    return word.substr(first, word.find_last_not_of(' ') - first + 1);
}

}  // namespace

std::vector<std::string> parse_aov_groups(std::string_view list) {
    std::vector<std::string_view> wanted{"colour"};
    const bool none = trimmed(list) == "none";
    for (std::size_t begin = 0; !none && begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        const std::string_view word = trimmed(list.substr(begin, end - begin));
        if (word == "all")
            for (const AovInfo& aov : aov_catalogue())
                wanted.push_back(aov.group);
        else if (is_group(word))
            wanted.push_back(word);
        else
            throw InputError(expected_found("aovs", accepted_groups(), "\"" + std::string(word) + "\""));
        begin = end + 1;
    }
    std::vector<std::string> planes;
    for (const AovInfo& aov : aov_catalogue())
        if (std::find(wanted.begin(), wanted.end(), aov.group) != wanted.end())
            planes.emplace_back(aov.name);
    return planes;
}

}  // namespace equistream
