#include "geometry_rung.h"
#include "picture_rungs.h"
#include "push_pull_rung.h"
#include "spread_rung.h"

#include <equistream/comma_list.h>
#include <equistream/error.h>

#include <array>

namespace equistream {

namespace {

constexpr std::array<std::string_view, 8> names = {"hidden",     "patches",  "earlier",  "small",
                                                   "small-wide", "geometry", "pushpull", "spread"};

constexpr std::array<std::string_view, 2> small_names = {"small", "small-wide"};

std::unique_ptr<FillRung> make_rung(std::string_view name) {
    if (name == "patches")
        return std::make_unique<PatchesRung>();
    if (name == "hidden")
        return std::make_unique<HiddenRung>();
    if (name == "earlier")
        return std::make_unique<EarlierRung>();
    if (name == "small")
        return std::make_unique<SmallRung>(SmallRung::Fills::all_gaps);
    if (name == "small-wide")
        return std::make_unique<SmallRung>(SmallRung::Fills::wide_gaps);
    if (name == "geometry")
        return std::make_unique<GeometryRung>();
    if (name == "pushpull")
        return std::make_unique<PushPullRung>();
    if (name == "spread")
        return std::make_unique<SpreadRung>();
    throw InputError(expected_found(
        "--fill", "none, or a list of patches, hidden, earlier, small, small-wide, geometry, pushpull and spread",
        "'" + std::string(name) + "'"));
}

}  // namespace

std::span<const std::string_view> fill_rung_names() {
    return names;
}

std::span<const std::string_view> small_rung_names() {
    return small_names;
}

FilledCounts fill_gaps(const FillLadder& ladder, const EyeView& eye, EyePicture& picture) {
    FilledCounts filled;
    Gaps gaps(picture.origin.view());
    for (const auto& rung : ladder)
        filled.emplace_back(rung->name(), rung->fill(eye, picture, gaps));
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
