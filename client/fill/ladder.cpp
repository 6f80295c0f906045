#include "rungs.h"

#include <equistream/error.h>

#include <array>

namespace equistream {

namespace {

constexpr std::array<std::string_view, 2> names = {"small", "spread"};

std::unique_ptr<FillRung> make_rung(const std::string& name) {
    if (name == "small")
        return std::make_unique<SmallRung>();
    if (name == "spread")
        return std::make_unique<SpreadRung>();
    throw InputError(expected_found("--fill", "none, or a list of small and spread", "'" + name + "'"));
}

}  // namespace

std::span<const std::string_view> fill_rung_names() {
    return names;
}

std::vector<std::unique_ptr<FillRung>> make_fill_ladder(const std::string& list) {
    std::vector<std::unique_ptr<FillRung>> ladder;
    if (list == "none")
        return ladder;
    std::size_t begin = 0;
    while (begin <= list.size()) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        ladder.push_back(make_rung(list.substr(begin, end - begin)));
        begin = end + 1;
    }
    return ladder;
}

}  // namespace equistream
