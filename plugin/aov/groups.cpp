#include <equistream/aov.h>
#include <equistream/aov_groups.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>

namespace equistream {
namespace {

/// "depth, motion, ..." as a user may type them.
std::string accepted_groups(bool only_in_all) {
    std::string text;
    std::string_view last;
    for (const AovInfo& aov : aov_catalogue()) {
        if (aov.group == "colour" || aov.group == last || (only_in_all && !aov.in_all))
            continue;
        last = aov.group;
        text += std::string(aov.group) + ", ";
    }
    return text + "all or none";
}

bool is_group(std::string_view word, bool only_in_all) {
    const auto catalogue = aov_catalogue();
    return std::any_of(catalogue.begin(), catalogue.end(),
                       [&](const AovInfo& a) { return a.group == word && (a.in_all || !only_in_all); });
}

}  // namespace

std::vector<std::string> parse_aov_groups(std::string_view list, bool only_in_all) {
    std::vector<std::string_view> wanted{"colour"};
    for (const std::string_view word : split_at_commas(list)) {
        if (word == "none" && trimmed(list) == "none")
            break;
        if (word == "all")
            for (const AovInfo& aov : aov_catalogue()) {
                if (aov.in_all)
                    wanted.push_back(aov.group);
            }
        else if (is_group(word, only_in_all))
            wanted.push_back(word);
        else
            throw InputError(expected_found("aovs", accepted_groups(only_in_all), "\"" + std::string(word) + "\""));
    }
    std::vector<std::string> planes;
    for (const AovInfo& aov : aov_catalogue())
        if (std::find(wanted.begin(), wanted.end(), aov.group) != wanted.end())
            planes.emplace_back(aov.name);
    return planes;
}

}  // namespace equistream
