// Greedy coverage against a plain one that looks at every block each time; slots from frame to frame.
#include <plugin/patches/block_choice.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace equistream {
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
