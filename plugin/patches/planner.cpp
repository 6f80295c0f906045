#include "planner.h"
#include "block_choice.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <cmath>

namespace equistream {
namespace {

/// The auxiliary spheres stand for eyes too: farther out than most, so they count for little, but what they uncover is
/// what eyes between the training ones may, and takes the rest of the budget.
constexpr double share_of_rim = 0.1;

glm::dvec3 in_single_precision(const glm::dvec3& v) {
    return {float(v.x), float(v.y), float(v.z)};
}

/// Spread over the ball: radii by shares of its volume, directions on a spiral (Fibonacci's), neither with the other.
std::vector<glm::dvec3> training_places(int count, double radius_m) {
    std::vector<glm::dvec3> places;
    const double golden = 0.5 * (std::sqrt(5.0) - 1);
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count;
        const double turn = 2 * pi * golden * i;
        const double share = std::fmod((i + 0.5) * golden * golden * 7, 1.0);
        const double flat = std::sqrt(1 - z * z), r = radius_m * std::cbrt(share);
        places.push_back(r * glm::dvec3(flat * std::cos(turn), z, flat * std::sin(turn)));
    }
    return places;
}

/// The arrangement of at most `count` slots that wastes fewest and is no more than twice as wide as high.
void set_grid(PatchAtlas& atlas, int count) {
    int best = 0;
    for (int columns = static_cast<int>(std::ceil(std::sqrt(count))); columns * columns <= 2 * count; ++columns)
        if (const int slots = count / columns * columns; slots > best) {
            best = slots;
            atlas.columns = columns;
            atlas.rows = count / columns;
        }
}

}  // namespace

std::vector<glm::dvec3> patch_offsets(double box_radius_m) {
    std::vector<glm::dvec3> offsets;
    const double golden = 0.5 * (1 + std::sqrt(5.0));
    const double scale = box_radius_m / std::sqrt(1 + golden * golden);
    for (const double a : {-scale, scale})
        for (const double b : {-golden * scale, golden * scale})
            for (int axis = 0; axis < 3; ++axis) {
                glm::dvec3 corner(0);
                corner[axis] = a;
                corner[(axis + 1) % 3] = b;
                offsets.push_back(in_single_precision(corner));
            }
    return offsets;
}

PatchAtlas empty_atlas(const PatchSettings& settings) {
    PatchAtlas atlas;
    atlas.sphere_width = settings.sphere.width;
    atlas.sphere_height = settings.sphere.height;
    atlas.range = settings.sphere.range;
    atlas.block_side = settings.block_side;
    atlas.offsets_m = settings.offsets_m.empty() ? patch_offsets(settings.box_radius_m) : settings.offsets_m;
    const double pixels = settings.budget * settings.sphere.width * settings.sphere.height;
    const int slots =
        static_cast<int>(std::min<double>(pixels / (settings.block_side * settings.block_side), max_patch_slots));
    if (slots < 1)
        throw InputError(expected_found("patches", "a budget of at least one patch",
                                        formatted("%.0f pixels", std::floor(std::max(0.0, pixels)))));
    set_grid(atlas, slots);
    atlas.slots.resize(static_cast<std::size_t>(atlas.columns) * static_cast<std::size_t>(atlas.rows));
    if (const auto problem = patch_atlas_problem(atlas))
        throw InputError("patches: " + *problem);
    return atlas;
}

int finest_patch_side(const EquirectCamera& sphere, double budget) {
    const double pixels = budget * sphere.width * sphere.height;
    int side = min_patch_side;
    while (side + 4 <= max_patch_side && pixels / (side * side) > max_patch_slots)
        side += 4;
    return side;
}

PatchPlan plan_patches(const PatchSettings& settings, const CastSphere& cast_sphere, const PatchAtlas* previous) {
    const auto start = Clock::now();
    PatchPlan plan{previous ? *previous : empty_atlas(settings), {}};
    PatchAtlas& atlas = plan.atlas;
    double cast_s = 0;
    const auto cast = [&](const glm::dvec3& offset_m) {
        DepthSphere sphere(settings.sphere, offset_m);
        const auto cast_start = Clock::now();
        cast_sphere(offset_m, settings.sphere, sphere.depth_m().view());
        cast_s += seconds_since(cast_start);
        return sphere;
    };
    const DepthSphere centre = cast(glm::dvec3(0));
    std::vector<DepthSphere> auxiliary;
    for (const glm::dvec3& offset : atlas.offsets_m)
        auxiliary.push_back(cast(offset));
    GapSamples samples;
    GapRule rule{settings.box_radius_m, settings.tolerance_rad, settings.block_side, share_of_rim, settings.stride};
    for (const DepthSphere& rim : auxiliary)
        append_gap_samples(rim, centre, auxiliary, rule, samples);
    rule.weight = 1;
    for (const glm::dvec3& place : training_places(settings.training_eyes, settings.box_radius_m))
        append_gap_samples(cast(place), centre, auxiliary, rule, samples);

    const auto columns = static_cast<BlockId>(atlas.block_columns()), rows = static_cast<BlockId>(atlas.block_rows());
    const std::size_t block_count = std::size_t{columns} * rows * atlas.offsets_m.size();
    std::vector<std::uint8_t> was_there(block_count, 0);
    for (const PatchAtlas::Slot& slot : atlas.slots)
        if (slot.used)
            was_there[(slot.offset_index * rows + slot.block_y) * columns + slot.block_x] = 1;
    const auto stay = static_cast<float>(1 + settings.hysteresis);
    const std::vector<BlockId> chosen = choose_blocks(samples, {atlas.slots.size(), block_count},
                                                      [&](BlockId b) { return was_there[b] ? stay : 1.0f; });
    std::vector<PatchAtlas::Slot> patches;
    for (const BlockId block : chosen)
        patches.push_back({static_cast<std::uint8_t>(block / (rows * columns)),
                           static_cast<std::uint16_t>(block % columns),
                           static_cast<std::uint16_t>(block / columns % rows), true});
    PatchFigures& figures = plan.figures;
    figures.kept_slots = assign_slots(std::move(patches), atlas);
    double gaps = 0;
    for (const float weight : samples.weight)
        gaps += weight;
    figures.covered = gaps > 0 ? covered_weight(samples, chosen, block_count) / gaps : 1;
    figures.coverable = gaps > 0 ? coverable_weight(samples) / gaps : 1;
    figures.pixel_share = static_cast<double>(chosen.size()) * settings.block_side * settings.block_side /
                          (static_cast<double>(settings.sphere.width) * settings.sphere.height);
    figures.cast_s = cast_s;
    figures.plan_s = seconds_since(start) - figures.cast_s;
    return plan;
}

}  // namespace equistream
