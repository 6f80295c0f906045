#pragma once
/// Received frames between the thread that delivers them and the one that displays them.
#include <equistream/camera.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace equistream {

// The bookkeeping behind a FrameRing: which slot holds which frame, and which thread may touch it.
//
// Two threads, and neither locks: slots change hands by one compare-and-swap of a word that holds the slot's state and
// how often it was filled, so that a slot that was filled again meanwhile is never taken for the one that was looked
// at. The displaying thread takes a bounded number of steps whatever the delivering one does.

/// What is known of a frame when it arrives.
struct FrameStamp {
    std::int64_t number = 0;   ///< ascending, as FrameInfo::index
    double frame_time_s = 0;   ///< on the server's clock, ascending with the number
    Pose pose{};               ///< of the head it was made for
    double arrival_s = 0;      ///< on the client's clock
    std::int64_t ordinal = 0;  ///< of all frames that were sent; a gap is a frame that did not come
};

/// How a frame came; each is one of these.
enum class Delivery {
    in_order,
    out_of_order,  ///< after one with a higher number; still to be shown, or not yet passed over
    late,          ///< after a later one was shown: good only to fill from
    doubled,       ///< refused: it was delivered before
    too_old        ///< refused: so far behind that nobody remembers whether it was delivered
};
inline constexpr std::size_t delivery_count = 5;
inline constexpr std::array<const char*, delivery_count> delivery_names = {"in_order", "out_of_order", "late",
                                                                           "doubled", "too_old"};

struct DeliveryCounts {
    std::array<std::int64_t, delivery_count> by{};  ///< by Delivery
    std::int64_t thinned = 0;  ///< of those taken, how many gave way to others before they could be shown

    std::int64_t operator[](Delivery which) const { return by[std::size_t(which)]; }
};

struct FrameRingOptions {
    std::size_t kept = 3;  ///< most frames shown at once: the current one and those before it
    /// At least 2 kept + 2. What is more holds frames that came before their time: play-out delay times frame rate.
    std::size_t capacity = 16;
};

class FrameSlots {
public:
    explicit FrameSlots(const FrameRingOptions& options);

    // The delivering thread.
    /// The slot that is the delivering thread's until the next deliver().
    std::size_t filling() const { return filling_; }
    /// Gives it to the displaying thread; of frames that are refused it stays.
    Delivery deliver(const FrameStamp& stamp);

    // The displaying thread.
    /// Slots of the newest frame at `frame_time_s` and of those before it, newest first; empty where there is none.
    /// They stay that thread's until the next show().
    std::span<const std::size_t> show(double frame_time_s);
    const FrameStamp& stamp(std::size_t slot) const { return slots_[slot].stamp; }
    /// The next frame that was taken, in the order of arrival, shown or not; nothing: no more so far. Of more than 256
    /// unasked for, those that come then are left out.
    std::optional<FrameStamp> next_arrival();

    // Any thread.
    DeliveryCounts counts() const;

private:
    enum State : std::uint64_t { free = 0, being_filled = 1, ready = 2, shown = 3 };
    static State state_of(std::uint64_t word) { return State(word & 3); }
    static std::uint64_t with_state(std::uint64_t word, State state) { return (word & ~std::uint64_t{3}) | state; }
    static std::uint64_t next_filling(std::uint64_t word) { return with_state(word + 4, being_filled); }

    struct alignas(64) Slot {
        std::atomic<std::uint64_t> word{free};
        /// Of `stamp`, for who does not own the slot: to be believed once it does.
        std::atomic<std::int64_t> number{0};
        std::atomic<double> frame_time_s{0};
        FrameStamp stamp{};
    };
    /// A slot as it was looked at.
    struct Candidate {
        std::size_t slot;
        std::uint64_t word;
        std::int64_t number;
        double frame_time_s;
    };

    Delivery classify(std::int64_t number) const;
    void mark_delivered(std::int64_t number);
    std::size_t take_slot_to_fill();
    std::optional<std::size_t> victim();
    bool take_newest_until(double frame_time_s);

    FrameRingOptions options_;
    std::unique_ptr<Slot[]> slots_;

    // The delivering thread's.
    std::size_t filling_ = 0;
    std::int64_t highest_ = -1;       ///< number delivered
    std::uint64_t window_ = 0;        ///< bit i: highest_ - i was
    std::vector<Candidate> victims_;  ///< memory for victim()
    static constexpr std::int64_t window_frames = 64;

    // The displaying thread's.
    std::vector<Candidate> candidates_;  ///< memory for show()
    std::vector<std::size_t> selected_;

    // Between them.
    std::atomic<std::int64_t> shown_number_{-1};
    std::atomic<double> shown_time_s_{0};
    static constexpr std::size_t max_arrivals = 256;
    std::array<FrameStamp, max_arrivals> arrivals_{};
    std::atomic<std::uint64_t> arrivals_written_{0}, arrivals_read_{0};
    std::array<std::atomic<std::int64_t>, delivery_count> deliveries_{};
    std::atomic<std::int64_t> thinned_{0};
};

// Received frames between the thread that delivers them and the one that displays them, each tagged with the pose it
// was made for. The display never waits, whatever becomes of the network: it is given the newest frame of the time it
// asks for, and those before it to fill from, as the paper's client goes on from "current and previous images" until
// the server recovers.
//
// Frames may come out of order, twice or too late; each is told apart and counted. Where more come than there is room
// for, frames that are past go first; then the one whose absence leaves the smallest hole in time, so that what a
// stall dammed up comes out thinned evenly rather than cut off. Memory is that of the payloads it was made with: no
// call allocates. A new source, whose numbers begin again, gets a new ring.
//
//     FrameRing<Picture> ring({.capacity = 16});
//     decode_into(ring.writable());                        // delivering thread
//     ring.deliver({number, frame_time_s, pose, now_s});
//     for (const std::size_t slot : ring.show(frame_time_s))    // displaying thread, newest first
//         use(ring.stamp(slot), ring.payload(slot));

template <typename Payload>
class FrameRing : public FrameSlots {
public:
    explicit FrameRing(const FrameRingOptions& options = {}) : FrameSlots(options), payloads_(options.capacity) {}

    /// The delivering thread's: to be filled before deliver(); holds what some earlier frame left.
    Payload& writable() { return payloads_[filling()]; }
    /// The displaying thread's, of a slot that show() gave, until the next one.
    Payload& payload(std::size_t slot) { return payloads_[slot]; }

private:
    std::vector<Payload> payloads_;
};

}  // namespace equistream
