#include "cover.h"

#include <queue>

namespace equistream {
namespace {

/// The samples of each block: `first[block]` to `first[block + 1]` in `samples`.
struct ByBlock {
    std::vector<std::uint32_t> first, samples;
};

ByBlock sorted_by_block(const GapSamples& samples, std::size_t block_count) {
    ByBlock by;
    by.first.assign(block_count + 1, 0);
    for (const BlockId block : samples.blocks)
        ++by.first[block + 1];
    for (std::size_t b = 0; b < block_count; ++b)
        by.first[b + 1] += by.first[b];
    by.samples.resize(samples.blocks.size());
    std::vector<std::uint32_t> next(by.first.begin(), by.first.end() - 1);
    for (std::size_t s = 0; s < samples.weight.size(); ++s)
        for (std::uint32_t i = samples.first[s]; i < samples.first[s + 1]; ++i)
            by.samples[next[samples.blocks[i]]++] = static_cast<std::uint32_t>(s);
    return by;
}

/// Most first; of equal ones the lower id, so that a plan is the same everywhere.
struct Entry {
    double gain;
    BlockId block;
    bool operator<(const Entry& other) const {
        return gain < other.gain || (gain == other.gain && block > other.block);
    }
};

}  // namespace

std::vector<BlockId> choose_blocks(const GapSamples& samples, const CoverLimits& limits,
                                   const std::function<float(BlockId)>& preference) {
    const ByBlock by = sorted_by_block(samples, limits.block_count);
    std::vector<std::uint8_t> covered(samples.weight.size(), 0);
    const auto gain = [&](BlockId block) {
        double sum = 0;
        for (std::uint32_t i = by.first[block]; i < by.first[block + 1]; ++i)
            sum += covered[by.samples[i]] ? 0 : samples.weight[by.samples[i]];
        return sum * preference(block);
    };
    std::vector<Entry> entries;
    for (BlockId block = 0; block < limits.block_count; ++block)
        if (by.first[block] != by.first[block + 1])
            entries.push_back({gain(block), block});
    std::priority_queue<Entry> queue(std::less<Entry>{}, std::move(entries));
    std::vector<BlockId> chosen;
    while (!queue.empty() && chosen.size() < limits.max_blocks) {
        const Entry best = queue.top();
        queue.pop();
        const double now = gain(best.block);
        if (now <= 0)
            continue;
        // What a block adds only shrinks, so an entry that is still right is the largest.
        if (now < best.gain) {
            queue.push({now, best.block});
            continue;
        }
        chosen.push_back(best.block);
        for (std::uint32_t i = by.first[best.block]; i < by.first[best.block + 1]; ++i)
            covered[by.samples[i]] = 1;
    }
    return chosen;
}

double covered_weight(const GapSamples& samples, std::span<const BlockId> blocks, std::size_t block_count) {
    std::vector<std::uint8_t> chosen(block_count, 0);
    for (const BlockId block : blocks)
        chosen[block] = 1;
    double sum = 0;
    for (std::size_t s = 0; s < samples.weight.size(); ++s)
        for (std::uint32_t i = samples.first[s]; i < samples.first[s + 1]; ++i)
            if (chosen[samples.blocks[i]]) {
                sum += samples.weight[s];
                break;
            }
    return sum;
}

double coverable_weight(const GapSamples& samples) {
    double sum = 0;
    for (std::size_t s = 0; s < samples.weight.size(); ++s)
        sum += samples.first[s] != samples.first[s + 1] ? samples.weight[s] : 0;
    return sum;
}

}  // namespace equistream
