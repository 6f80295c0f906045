#include "block_choice.h"

#include <queue>
#include <tuple>

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

using Slot = PatchAtlas::Slot;

std::size_t assign_slots(std::vector<Slot> chosen, PatchAtlas& atlas) {
    // Column by column, so that patches below one another follow each other: that is cheap to send.
    const auto key = [](const Slot& s) { return std::tuple(s.offset_index, s.block_x, s.block_y); };
    const auto before = [&](const Slot& a, const Slot& b) { return key(a) < key(b); };
    std::sort(chosen.begin(), chosen.end(), before);
    constexpr std::size_t nowhere = static_cast<std::size_t>(-1);
    std::vector<std::size_t> slot_of(chosen.size(), nowhere);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < atlas.slots.size(); ++i) {
        Slot& slot = atlas.slots[i];
        if (!slot.used)
            continue;
        const auto found = std::lower_bound(chosen.begin(), chosen.end(), slot, before);
        if (found != chosen.end() && *found == slot) {
            slot_of[static_cast<std::size_t>(found - chosen.begin())] = i;
            ++kept;
        } else {
            slot = {};
        }
    }
    const auto is_free = [&](std::size_t slot) { return slot < atlas.slots.size() && !atlas.slots[slot].used; };
    std::size_t free = 0;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        if (slot_of[i] != nowhere)
            continue;
        while (!is_free(free))
            ++free;
        Slot below;
        if (i > 0) {
            below = chosen[i - 1];
            ++below.block_y;
        }
        slot_of[i] = below == chosen[i] && is_free(slot_of[i - 1] + 1) ? slot_of[i - 1] + 1 : free;
        atlas.slots[slot_of[i]] = chosen[i];
    }
    return kept;
}

}  // namespace equistream
