#pragma once
/// The known word that a mistyped one was probably meant to be.
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::cli {

/// How many letters must be put in, left out, replaced or swapped with their neighbour to turn one word into the other.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        next[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                next[j] = std::min(next[j], before[j - 2] + 1);
        }
        before = row;
        row = next;
    }
    return row.back();
}

/// The nearest of `known`, or an empty word where none is near: one letter in three may differ, and what begins with
/// the whole word is near.
template <typename Words>
std::string nearest_word(std::string_view word, const Words& known) {
    std::string nearest;
    std::size_t least = word.size() / 3 + 1;
    for (const auto& each : known) {
        const std::string_view candidate = each;
        const bool is_begun = word.size() >= 3 && candidate.starts_with(word);
        const std::size_t distance = is_begun ? 1 : edit_distance(word, candidate);
        if (distance < least) {
            least = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

/// "; did you mean NAME?", or nothing where no known word is near.
template <typename Words>
std::string did_you_mean(std::string_view word, const Words& known) {
    const std::string nearest = nearest_word(word, known);
    return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

}  // namespace equistream::cli
