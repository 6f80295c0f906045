// A room with furniture, all boxes: what eyes that the planner has not seen uncover is in the patches.
#include <equistream/error.h>
#include <equistream/patches.h>

#include <plugin/patches/block_choice.h>
#include <plugin/patches/gap_samples.h>
#include <plugin/patches/planner.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>

namespace equistream {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double box_radius_m = 0.1315;

struct Box {
    glm::dvec3 low, high;
};

const Box room{{-4, -1.5, -5}, {5, 2, 4}};
const Box furniture[] = {{{0.6, -1.5, -2.2}, {1.1, 2, -1.7}},       // a pillar
                         {{-2.4, -1.5, -1.4}, {-1.4, -0.6, -0.4}},  // a table
                         {{-1.2, -0.4, 1.5}, {-0.7, 0.4, 1.6}}};    // a board in the air

/// Closed form: where the ray leaves the room, or the nearest box that it enters.
double distance_m(const glm::dvec3& origin, const glm::dvec3& direction) {
    const auto crossing = [&](const Box& box) {
        const glm::dvec3 a = (box.low - origin) / direction, b = (box.high - origin) / direction;
        const glm::dvec3 enter = glm::min(a, b), leave = glm::max(a, b);
        return std::pair(std::max({enter.x, enter.y, enter.z}), std::min({leave.x, leave.y, leave.z}));
    };
    double nearest = crossing(room).second;
    for (const Box& box : furniture)
        if (const auto [enter, leave] = crossing(box); enter < leave && enter > 0)
            nearest = std::min(nearest, enter);
    return nearest;
}

void cast(const glm::dvec3& offset_m, const EquirectCamera& camera, ImageView<float> depth_m) {
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            depth_m.pixel(x, y)[0] = static_cast<float>(distance_m(offset_m, camera.direction(x + 0.5, y + 0.5)));
}

PatchSettings settings_of(int side, double budget) {
    PatchSettings settings;
    settings.sphere = {480, 240, {}};
    settings.box_radius_m = box_radius_m;
    settings.block_side = side;
    settings.training_eyes = 32;  // few corners to look round: more eyes find nothing new
    settings.stride = 3;
    settings.budget = budget;
    return settings;
}

/// Whether a point is what is seen from `from` in its direction, give or take a thousandth.
bool sees(const glm::dvec3& from, const glm::dvec3& point) {
    const double r = glm::distance(from, point);
    return distance_m(from, (point - from) / r) > r * 0.999;
}

/// Whether one of the sphere's four pixels around a point's direction shows that very place, so that a client colours
/// the point from there though an edge hides it by a fraction of a pixel.
bool pixels_around_show(const EquirectCamera& sphere, const glm::dvec3& point) {
    const glm::dvec2 corner = glm::floor(sphere.pixel(point) - 0.5);
    for (const glm::dvec2 step : {glm::dvec2(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
        const glm::dvec3 d = sphere.direction(corner.x + step.x + 0.5, corner.y + step.y + 0.5);
        const glm::dvec3 shown = d * distance_m(glm::dvec3(0), d);
        if (glm::distance(shown, point) < 6 * sphere.pixel_angle_rad() * glm::length(point))
            return true;
    }
    return false;
}

struct Uncovered {
    int gaps = 0, shown = 0;
};

/// By visibility in closed form, with no depth picture between: points that random eyes see and the centre does not,
/// and those of them that lie in a patch whose own place sees them.
Uncovered look_around(const PatchAtlas& atlas, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> side(-1, 1);
    const PatchSlots index(atlas);
    Uncovered found;
    for (int i = 0; i < 400000; ++i) {
        glm::dvec3 eye, towards;
        do
            eye = {side(random), side(random), side(random)};
        while (glm::length(eye) > 1);
        do
            towards = {side(random), side(random), side(random)};
        while (glm::length(towards) > 1);
        eye *= box_radius_m;
        towards = glm::normalize(towards);
        const glm::dvec3 point = eye + towards * distance_m(eye, towards);
        if (sees(glm::dvec3(0), point) || pixels_around_show(atlas.sphere(), point))
            continue;
        ++found.gaps;
        for (std::size_t k = 0; k < atlas.offsets_m.size(); ++k) {
            const glm::dvec2 at = atlas.sphere().pixel(point - atlas.offsets_m[k]);
            const int x = std::min(static_cast<int>(at.x), atlas.sphere_width - 1);
            const int y = std::min(static_cast<int>(at.y), atlas.sphere_height - 1);
            if (index.atlas_pixel(static_cast<int>(k), x, y) && sees(atlas.offsets_m[k], point)) {
                ++found.shown;
                break;
            }
        }
    }
    return found;
}

TEST(DepthSpheres, ASphereOfOneRowHasPlanesThatFaceIt) {
    DepthSphere sphere({8, 1, {}}, glm::dvec3(0));
    std::ranges::fill(sphere.depth_m().samples(), 2.0f);
    for (int x = 0; x < 8; ++x)
        EXPECT_EQ(sphere.plane(x, 0), 0.5 * sphere.direction(x, 0)) << x;
}

TEST(PatchPlan, BlocksAreAsSmallAsTheAtlasAllows) {
    EXPECT_EQ(finest_patch_side({1920, 960, {}}, 0.1), 4) << "11,520 slots";
    EXPECT_EQ(finest_patch_side({3840, 1920, {}}, 0.1), 8) << "46,080 of 4 pixels, 11,520 of 8";
    EXPECT_EQ(finest_patch_side({3840, 1920, {}}, 0.02), 4);
    EXPECT_EQ(finest_patch_side({16384, 8192, {}}, 1), max_patch_side) << "as many as there may be";
}

TEST(PatchPlan, ShowsWhatRandomEyesUncover) {
    const PatchPlan plan = plan_patches(settings_of(8, 0.1), cast);
    ASSERT_FALSE(patch_atlas_problem(plan.atlas));
    EXPECT_LE(plan.figures.pixel_share, 0.1);
    const Uncovered found = look_around(plan.atlas, 99);
    ASSERT_GT(found.gaps, 500);
    EXPECT_GE(found.shown, 0.95 * found.gaps) << "of " << found.gaps << ", pixels " << plan.figures.pixel_share;
}

TEST(PatchPlan, MorePixelsShowMore) {
    double before = 0;
    for (const double budget : {0.02, 0.06}) {
        const PatchPlan plan = plan_patches(settings_of(8, budget), cast);
        EXPECT_LE(plan.figures.pixel_share, budget);
        EXPECT_GT(plan.figures.covered, before);
        EXPECT_LE(plan.figures.covered, plan.figures.coverable);
        before = plan.figures.covered;
    }
}

TEST(PatchPlan, TheSameTwiceAndSlotsStayWhenNothingMoves) {
    const PatchSettings settings = settings_of(8, 0.05);
    const PatchPlan first = plan_patches(settings, cast), again = plan_patches(settings, cast);
    EXPECT_EQ(first.atlas.slots, again.atlas.slots);
    const PatchPlan next = plan_patches(settings, cast, &first.atlas);
    EXPECT_EQ(next.atlas.slots, first.atlas.slots);
    EXPECT_EQ(next.figures.kept_slots, first.atlas.used_slots());
}

TEST(PatchPlan, MostSlotsStayOnAWalk) {
    const PatchSettings settings = settings_of(8, 0.1);
    const PatchPlan first = plan_patches(settings, cast);
    const glm::dvec3 step(0, 0, -0.03);  // a frame of a walking head
    const auto moved = [&](const glm::dvec3& offset_m, const EquirectCamera& camera, ImageView<float> depth_m) {
        cast(offset_m + step, camera, depth_m);
    };
    const PatchPlan next = plan_patches(settings, moved, &first.atlas), anew = plan_patches(settings, moved);
    EXPECT_GT(static_cast<double>(next.figures.kept_slots), 0.6 * static_cast<double>(next.atlas.used_slots()));
    EXPECT_GT(next.figures.covered, 0.97 * anew.figures.covered) << "what staying costs";
}

TEST(PatchPlan, NothingIsUncoveredInAnEmptyRoom) {
    const PatchPlan plan = plan_patches(settings_of(16, 0.1),
                                        [](const glm::dvec3&, const EquirectCamera& camera, ImageView<float> depth_m) {
                                            for (int y = 0; y < camera.height; ++y)
                                                std::fill_n(depth_m.row(y), camera.width, static_cast<float>(infinity));
                                        });
    EXPECT_EQ(plan.atlas.used_slots(), 0u);
    EXPECT_EQ(plan.figures.covered, 1);
}

TEST(PatchPlan, ABudgetBelowOnePatchIsRefused) {
    try {
        empty_atlas(settings_of(64, 0.01));
        FAIL() << "accepted";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "patches: expected a budget of at least one patch, found 1152 pixels");
    }
    const PatchAtlas atlas = empty_atlas(settings_of(16, 0.1));
    EXPECT_EQ(atlas.columns * atlas.rows, 45);
    EXPECT_GE(atlas.columns, atlas.rows);
}

}  // namespace

// Greedy coverage against a plain one that looks at every block each time; slots from frame to frame.

namespace {

constexpr std::size_t block_count = 60;

GapSamples random_samples(unsigned seed) {
    std::mt19937 random(seed);
    GapSamples samples;
    samples.first.push_back(0);
    for (int i = 0; i < 400; ++i) {
        samples.weight.push_back(static_cast<float>(1 + random() % 8));  // sums are exact
        std::set<BlockId> blocks;
        for (auto k = random() % 5; k > 0; --k)
            blocks.insert(static_cast<BlockId>(std::min(random() % block_count, random() % block_count)));
        samples.blocks.insert(samples.blocks.end(), blocks.begin(), blocks.end());
        samples.first.push_back(static_cast<std::uint32_t>(samples.blocks.size()));
    }
    return samples;
}

std::vector<BlockId> plainly_chosen(const GapSamples& samples, std::size_t most, float preference_of_odd) {
    std::vector<bool> covered(samples.weight.size(), false);
    std::vector<BlockId> chosen;
    while (chosen.size() < most) {
        double best_gain = 0;
        BlockId best = 0;
        for (BlockId block = 0; block < block_count; ++block) {
            double gain = 0;
            for (std::size_t s = 0; s < covered.size(); ++s)
                for (std::uint32_t i = samples.first[s]; i < samples.first[s + 1]; ++i)
                    gain += samples.blocks[i] == block && !covered[s] ? samples.weight[s] : 0;
            gain *= block % 2 == 1 ? preference_of_odd : 1;
            if (gain > best_gain) {
                best_gain = gain;
                best = block;
            }
        }
        if (best_gain == 0)
            break;
        chosen.push_back(best);
        for (std::size_t s = 0; s < covered.size(); ++s)
            for (std::uint32_t i = samples.first[s]; i < samples.first[s + 1]; ++i)
                if (samples.blocks[i] == best)
                    covered[s] = true;
    }
    return chosen;
}

TEST(PatchCover, IsThatOfAPlainGreedySearch) {
    for (unsigned seed = 0; seed < 40; ++seed) {
        const GapSamples samples = random_samples(seed);
        for (const float preference : {1.0f, 1.25f})
            EXPECT_EQ(choose_blocks(samples, {25, block_count}, [&](BlockId b) { return b % 2 == 1 ? preference : 1; }),
                      plainly_chosen(samples, 25, preference));
    }
}

TEST(PatchCover, AllBlocksCoverWhatAnyCovers) {
    const GapSamples samples = random_samples(7);
    const auto chosen = choose_blocks(samples, {block_count, block_count}, [](BlockId) { return 1.0f; });
    EXPECT_LT(chosen.size(), block_count) << "those that add nothing are left out";
    EXPECT_EQ(covered_weight(samples, chosen, block_count), coverable_weight(samples));
    EXPECT_LT(covered_weight(samples, std::span(chosen).first(5), block_count), coverable_weight(samples));
}

TEST(PatchSlots, BlocksThatStayKeepTheirs) {
    using Slot = PatchAtlas::Slot;
    PatchAtlas atlas;
    atlas.columns = 4;
    atlas.rows = 2;
    atlas.slots.resize(8);
    EXPECT_EQ(assign_slots({{1, 3, 1, true}, {0, 2, 2, true}, {1, 3, 0, true}, {0, 2, 1, true}}, atlas), 0u);
    const std::vector<Slot> first = {
        {0, 2, 1, true}, {0, 2, 2, true}, {1, 3, 0, true}, {1, 3, 1, true}, {}, {}, {}, {}};
    EXPECT_EQ(atlas.slots, first);
    EXPECT_EQ(assign_slots({{1, 3, 1, true}, {0, 9, 9, true}, {0, 2, 2, true}, {2, 0, 0, true}}, atlas), 2u);
    const std::vector<Slot> second = {
        {0, 9, 9, true}, {0, 2, 2, true}, {2, 0, 0, true}, {1, 3, 1, true}, {}, {}, {}, {}};
    EXPECT_EQ(atlas.slots, second);
    EXPECT_EQ(assign_slots({}, atlas), 0u);
    EXPECT_EQ(atlas.used_slots(), 0u);
}

}  // namespace
}  // namespace equistream
