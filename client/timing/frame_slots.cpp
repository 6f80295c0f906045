#include "frame_slots.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace equistream {

/// Frame times and the clock's are sums of doubles: what is meant to be equal differs by less.
constexpr double same_time_s = 1e-6;

FrameSlots::FrameSlots(const FrameRingOptions& options)
    : options_(options), slots_(std::make_unique<Slot[]>(options.capacity)) {
    // While it takes new ones, the displaying thread holds at most twice what it keeps; one is being filled, and one
    // more must be there to be filled next.
    assert(options.kept >= 1 && options.capacity >= 2 * options.kept + 2);
    victims_.reserve(options.capacity);
    candidates_.reserve(options.capacity);
    selected_.reserve(options.kept);
    slots_[filling_].word.store(next_filling(free), std::memory_order_relaxed);
}

Delivery FrameSlots::classify(std::int64_t number) const {
    if (number > highest_)
        return Delivery::in_order;
    const std::int64_t behind = highest_ - number;
    if (behind >= window_frames)
        return Delivery::too_old;
    if ((window_ >> behind & 1) != 0)
        return Delivery::doubled;
    return number < shown_number_.load(std::memory_order_relaxed) ? Delivery::late : Delivery::out_of_order;
}

void FrameSlots::mark_delivered(std::int64_t number) {
    if (number > highest_) {
        const std::int64_t ahead = number - highest_;
        window_ = ahead < window_frames ? window_ << ahead : 0;
        highest_ = number;
    }
    window_ |= std::uint64_t{1} << (highest_ - number);
}

Delivery FrameSlots::deliver(const FrameStamp& stamp) {
    const Delivery delivery = classify(stamp.number);
    deliveries_[std::size_t(delivery)].fetch_add(1, std::memory_order_relaxed);
    if (delivery == Delivery::doubled || delivery == Delivery::too_old)
        return delivery;
    mark_delivered(stamp.number);
    Slot& slot = slots_[filling_];
    slot.stamp = stamp;
    slot.number.store(stamp.number, std::memory_order_relaxed);
    slot.frame_time_s.store(stamp.frame_time_s, std::memory_order_relaxed);
    slot.word.store(with_state(slot.word.load(std::memory_order_relaxed), ready), std::memory_order_release);

    const std::uint64_t written = arrivals_written_.load(std::memory_order_relaxed);
    if (written - arrivals_read_.load(std::memory_order_acquire) < max_arrivals) {
        arrivals_[written % max_arrivals] = stamp;
        arrivals_written_.store(written + 1, std::memory_order_release);
    }
    filling_ = take_slot_to_fill();
    return delivery;
}

std::size_t FrameSlots::take_slot_to_fill() {
    // A slot slips away only when the displaying thread takes it, which gives others back: the next look finds one.
    for (;;) {
        for (std::size_t i = 0; i < options_.capacity; ++i) {
            std::uint64_t word = slots_[i].word.load(std::memory_order_acquire);
            if (state_of(word) == free) {
                slots_[i].word.store(next_filling(word), std::memory_order_relaxed);
                return i;
            }
        }
        if (const std::optional<std::size_t> taken = victim())
            return *taken;
    }
}

/// Of frames that wait to be shown, the one that is missed least, if it could be had.
std::optional<std::size_t> FrameSlots::victim() {
    const std::int64_t shown_number = shown_number_.load(std::memory_order_relaxed);
    victims_.clear();
    for (std::size_t i = 0; i < options_.capacity; ++i) {
        const std::uint64_t word = slots_[i].word.load(std::memory_order_relaxed);
        if (state_of(word) == ready)
            victims_.push_back({i, word, slots_[i].number.load(std::memory_order_relaxed),
                                slots_[i].frame_time_s.load(std::memory_order_relaxed)});
    }
    if (victims_.empty())
        return std::nullopt;
    std::ranges::sort(victims_, {}, &Candidate::number);
    std::size_t chosen = 0;
    // The newest stays: it is where the stream is by now. Those older than what is shown leave no hole at all.
    if (victims_.size() > 1) {
        double min_hole_s = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i + 1 < victims_.size(); ++i) {
            const double before_s = i > 0               ? victims_[i - 1].frame_time_s
                                    : shown_number >= 0 ? shown_time_s_.load(std::memory_order_relaxed)
                                                        : -std::numeric_limits<double>::infinity();
            if (const double hole_s = victims_[i + 1].frame_time_s - before_s; hole_s < min_hole_s) {
                min_hole_s = hole_s;
                chosen = i;
            }
        }
    }
    const Candidate& victim = victims_[chosen];
    std::uint64_t word = victim.word;
    if (!slots_[victim.slot].word.compare_exchange_strong(word, next_filling(word), std::memory_order_acquire,
                                                          std::memory_order_relaxed))
        return std::nullopt;
    if (victim.number > shown_number)
        thinned_.fetch_add(1, std::memory_order_relaxed);
    return victim.slot;
}

/// Whether all that was chosen could be had; what could is the displaying thread's in any case.
bool FrameSlots::take_newest_until(double frame_time_s) {
    candidates_.clear();
    for (std::size_t i = 0; i < options_.capacity; ++i) {
        Slot& slot = slots_[i];
        const std::uint64_t word = slot.word.load(std::memory_order_acquire);
        if (state_of(word) != ready && state_of(word) != shown)
            continue;
        const Candidate candidate{i, word, slot.number.load(std::memory_order_relaxed),
                                  slot.frame_time_s.load(std::memory_order_relaxed)};
        if (candidate.frame_time_s <= frame_time_s + same_time_s)
            candidates_.push_back(candidate);
    }
    std::ranges::sort(candidates_, std::ranges::greater{}, &Candidate::number);
    candidates_.resize(std::min(candidates_.size(), options_.kept));
    selected_.clear();
    bool all = true;
    for (const Candidate& candidate : candidates_) {
        std::uint64_t word = candidate.word;
        if (state_of(word) == shown ||
            slots_[candidate.slot].word.compare_exchange_strong(word, with_state(word, shown),
                                                                std::memory_order_acquire, std::memory_order_relaxed))
            selected_.push_back(candidate.slot);
        else
            all = false;
    }
    return all;
}

std::span<const std::size_t> FrameSlots::show(double frame_time_s) {
    // One that slipped away was filled again, with a newer frame: as often as there are slots, and no oftener, is it
    // worth another look.
    for (std::size_t looks = 0; looks < options_.capacity && !take_newest_until(frame_time_s); ++looks) {
    }
    for (std::size_t i = 0; i < options_.capacity; ++i) {
        const std::uint64_t word = slots_[i].word.load(std::memory_order_relaxed);
        if (state_of(word) == shown && std::ranges::count(selected_, i) == 0)
            slots_[i].word.store(with_state(word, free), std::memory_order_release);
    }
    if (!selected_.empty()) {
        const FrameStamp& current = stamp(selected_.front());
        shown_time_s_.store(current.frame_time_s, std::memory_order_relaxed);
        shown_number_.store(current.number, std::memory_order_relaxed);
    }
    return selected_;
}

std::optional<FrameStamp> FrameSlots::next_arrival() {
    const std::uint64_t read = arrivals_read_.load(std::memory_order_relaxed);
    if (read == arrivals_written_.load(std::memory_order_acquire))
        return std::nullopt;
    const FrameStamp stamp = arrivals_[read % max_arrivals];
    arrivals_read_.store(read + 1, std::memory_order_release);
    return stamp;
}

DeliveryCounts FrameSlots::counts() const {
    DeliveryCounts counts;
    for (std::size_t i = 0; i < delivery_count; ++i)
        counts.by[i] = deliveries_[i].load(std::memory_order_relaxed);
    counts.thinned = thinned_.load(std::memory_order_relaxed);
    return counts;
}

}  // namespace equistream
