#include "geometry_rung.h"
#include "picture_rungs.h"
#include "push_pull_rung.h"
#include "spread_rung.h"

#include <equistream/comma_list.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace equistream {

namespace {

using Maker = std::unique_ptr<FillRung> (*)();

template <typename Rung>
std::unique_ptr<FillRung> make() {
    return std::make_unique<Rung>();
}

template <SmallRung::Fills fills>
std::unique_ptr<FillRung> make_small() {
    return std::make_unique<SmallRung>(fills);
}

/// In the order in which they are best run.
constexpr std::array<std::pair<std::string_view, Maker>, 8> makers = {{
    {"hidden", make<HiddenRung>},
    {"patches", make<PatchesRung>},
    {"earlier", make<EarlierRung>},
    {"small", make_small<SmallRung::Fills::all_gaps>},
    {"small-wide", make_small<SmallRung::Fills::wide_gaps>},
    {"geometry", make<GeometryRung>},
    {"pushpull", make<PushPullRung>},
    {"spread", make<SpreadRung>},
}};

constexpr auto names = [] {
    std::array<std::string_view, makers.size()> found;
    std::ranges::transform(makers, found.begin(), [](const auto& maker) { return maker.first; });
    return found;
}();

constexpr std::array<std::string_view, 2> small_names = {"small", "small-wide"};

std::unique_ptr<FillRung> make_rung(std::string_view name) {
    const auto found = std::ranges::find(makers, name, [](const auto& maker) { return maker.first; });
    if (found == makers.end())
        throw InputError(expected_found("--fill", "none, or a list of " + in_a_sentence(names, " and "),
                                        "'" + std::string(name) + "'"));
    return found->second();
}

}  // namespace

std::span<const std::string_view> fill_rung_names() {
    return names;
}

std::span<const std::string_view> small_rung_names() {
    return small_names;
}

FilledCounts fill_gaps(const FillLadder& ladder, const EyeView& eye, EyePicture& picture) {
    std::vector<double> unused(ladder.size());
    return fill_gaps(ladder, eye, picture, unused);
}

FilledCounts fill_gaps(const FillLadder& ladder, const EyeView& eye, EyePicture& picture, std::span<double> rung_ms) {
    assert(rung_ms.size() == ladder.size());
    FilledCounts filled;
    Gaps gaps(picture.origin.view());
    for (std::size_t i = 0; i < ladder.size(); ++i) {
        const auto start = Clock::now();
        filled.emplace_back(ladder[i]->name(), ladder[i]->fill(eye, picture, gaps));
        rung_ms[i] = milliseconds_since(start);
    }
    return filled;
}

FillLadder make_fill_ladder(const std::string& list) {
    FillLadder ladder;
    if (list == "none")
        return ladder;
    for (const std::string_view name : split_at_commas(list))
        ladder.push_back(make_rung(name));
    return ladder;
}

}  // namespace equistream
