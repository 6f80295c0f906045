#pragma once
/// Received frames between the thread that delivers them and the one that displays them, each tagged with the pose it
/// was made for. The display never waits, whatever becomes of the network: it is given the newest frame of the time it
/// asks for, and those before it to fill from, as the paper's client goes on from "current and previous images" until
/// the server recovers.
///
/// Frames may come out of order, twice or too late; each is told apart and counted. Where more come than there is room
/// for, frames that are past go first; then the one whose absence leaves the smallest hole in time, so that what a
/// stall dammed up comes out thinned evenly rather than cut off. Memory is that of the payloads it was made with: no
/// call allocates. A new source, whose numbers begin again, gets a new ring.
///
///     FrameRing<Picture> ring({.capacity = 16});
///     decode_into(ring.writable());                        // delivering thread
///     ring.deliver({number, frame_time_s, pose, now_s});
///     for (const auto& frame : ring.show(frame_time_s))    // displaying thread, newest first
///         use(frame.stamp(), frame.payload());
#include "frame_slots.h"

#include <utility>

namespace equistream {

template <typename Payload>
class FrameRing {
public:
    /// Borrowed until the next show().
    class Frame {
    public:
        const FrameStamp& stamp() const { return ring_->slots_.stamp(slot_); }
        Payload& payload() const { return ring_->payloads_[slot_]; }

    private:
        friend FrameRing;
        Frame(FrameRing* ring, std::size_t slot) : ring_(ring), slot_(slot) {}
        FrameRing* ring_;
        std::size_t slot_;
    };

    explicit FrameRing(const FrameRingOptions& options = {}) : slots_(options), payloads_(options.capacity) {}

    // The delivering thread.
    /// To be filled before deliver(); holds what some earlier frame left.
    Payload& writable() { return payloads_[slots_.filling()]; }
    Delivery deliver(const FrameStamp& stamp) { return slots_.deliver(stamp); }

    // The displaying thread.
    class Frames {
    public:
        std::size_t size() const { return slots_.size(); }
        bool empty() const { return slots_.empty(); }
        Frame operator[](std::size_t i) const { return {ring_, slots_[i]}; }

        class Iterator {
        public:
            Frame operator*() const { return (*frames_)[i_]; }
            Iterator& operator++() {
                ++i_;
                return *this;
            }
            bool operator==(const Iterator& other) const { return i_ == other.i_; }

        private:
            friend Frames;
            Iterator(const Frames* frames, std::size_t i) : frames_(frames), i_(i) {}
            const Frames* frames_;
            std::size_t i_;
        };
        Iterator begin() const { return {this, 0}; }
        Iterator end() const { return {this, size()}; }

    private:
        friend FrameRing;
        Frames(FrameRing* ring, std::span<const std::size_t> slots) : ring_(ring), slots_(slots) {}
        FrameRing* ring_;
        std::span<const std::size_t> slots_;
    };
    /// The newest frame at `frame_time_s` and those before it, newest first; empty where none is that old.
    Frames show(double frame_time_s) { return {this, slots_.show(frame_time_s)}; }
    /// Arrivals one by one, for a MediaClock; nothing: no more so far.
    std::optional<FrameStamp> next_arrival() { return slots_.next_arrival(); }

    // Any thread.
    DeliveryCounts counts() const { return slots_.counts(); }

private:
    FrameSlots slots_;
    std::vector<Payload> payloads_;
};

}  // namespace equistream
