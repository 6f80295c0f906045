#include "frame_loader.h"

#include <equistream/error.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

namespace equistream {

namespace {

/// Of a recorded source; the ring has room for them while it keeps what is shown.
constexpr std::size_t max_ahead = 3;
/// As many as a play-out delay takes, and some: a quarter of a second at 30 frames/s.
constexpr FrameRingOptions ring_options{.kept = 1, .capacity = 12};

/// Before the nth attempt to reach a server again.
std::chrono::duration<double> pause_before(int attempt) {
    constexpr double first_s = 0.25, longest_s = 4;
    return std::chrono::duration<double>(std::min(longest_s, first_s * double(1 << std::min(attempt - 1, 10))));
}

}  // namespace

FrameLoader::FrameLoader(std::string source, FeedOptions options)
    : source_(std::move(source)), options_(std::move(options)), reel_(std::make_shared<FrameReel>(ring_options)) {
    options_.interrupted = [this, asked = std::move(options_.interrupted)] {
        if (asked && asked())
            return true;
        const std::lock_guard lock(mutex_);
        return stopping_ || (!is_open_ && is_late());
    };
    feed_ = open_feed(source_, options_);
    ReceivedFrame frame = first_sound_frame();
    {
        const std::lock_guard lock(mutex_);
        is_open_ = true;
    }
    is_live_ = feed_->is_live();
    transfers_ = feed_->transfers();
    summary_ = feed_->summary();
    if (!is_live_)  // to jump may take longer
        options_.first_frame_limit_s = std::numeric_limits<double>::infinity();
    first_ = frame.main.info;
    is_posed_ = frame.posed;
    wanted_first_ = first_.index;
    deliver(std::move(frame));
    thread_ = std::thread([this] { run(); });
}

/// Those before it cannot be shown, and their tags say nothing of the source.
ReceivedFrame FrameLoader::first_sound_frame() {
    std::string problem;
    while (std::optional<ReceivedFrame> frame = feed_->next())
        try {
            require_tagged_sizes(*frame);
            return std::move(*frame);
        } catch (const WorkError& unsound) {
            if (problem.empty())
                problem = source_ + ": " + unsound.what();
        }
    if (!problem.empty())
        throw WorkError(problem);
    throw InputError(expected_found(source_, "frames", feed_->truncation().empty() ? "none" : feed_->truncation()));
}

FrameLoader::~FrameLoader() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

bool FrameLoader::may_read() const {
    return !ended_ && !failure_ && (is_live_ || ahead_ < max_ahead);
}

void FrameLoader::run() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        if (!may_read()) {
            changed_.wait(lock);
            continue;
        }
        const unsigned seeks = seeks_;
        try {
            read(lock);
        } catch (...) {
            if (!lock.owns_lock())
                lock.lock();
            if (seeks == seeks_)  // else nobody waits for what failed
                fail(lock);
        }
    }
}

void FrameLoader::fail(std::unique_lock<std::mutex>& lock) {
    if (is_live_)
        wait_to_try_again(lock);
    else
        failure_ = std::current_exception();
}

void FrameLoader::hang_up(std::unique_lock<std::mutex>& lock) {
    lock.unlock();  // who closes may ask whether to stop
    feed_.reset();
    lock.lock();
}

void FrameLoader::wait_to_try_again(std::unique_lock<std::mutex>& lock) {
    ++attempts_;
    const unsigned seeks = seeks_;
    hang_up(lock);
    changed_.wait_for(lock, pause_before(attempts_), [&] { return stopping_ || seeks != seeks_; });
}

/// Takes the frame into the reel; locks nothing.
void FrameLoader::deliver(ReceivedFrame frame) {
    const FrameInfo& info = frame.main.info;
    const FrameStamp stamp{info.index, info.time_s, info.head, now_s()};
    reel_->writable() = {std::make_shared<const ReceivedFrame>(std::move(frame)), feed_->fraction_done().value_or(0)};
    const Delivery delivery = reel_->deliver(stamp);
    newest_ = stamp.number;
    if (delivery != Delivery::doubled && delivery != Delivery::too_old)  // else nobody ever passes it
        ++ahead_;
    ++figures_.frames;
    count_bytes();
}

void FrameLoader::count_bytes() {
    std::int64_t bytes = 0;
    for (const FeedTrack& track : feed_->tracks())
        bytes += track.bytes;
    figures_.bytes += bytes - std::exchange(feed_bytes_, bytes);
}

LoaderFigures FrameLoader::figures() const {
    const std::lock_guard lock(mutex_);
    return figures_;
}

void FrameLoader::read(std::unique_lock<std::mutex>& lock) {
    const unsigned seeks = seeks_;
    FeedOptions options = options_;
    if (!is_live_)
        options.first_frame = wanted_first_;
    lock.unlock();
    if (!feed_ || (opened_for_ != seeks && (is_live_ || !feed_->seek(options.first_frame)))) {
        feed_.reset();
        feed_bytes_ = 0;
        feed_ = open_feed(source_, options);
    }
    opened_for_ = seeks;
    std::optional<ReceivedFrame> frame = feed_->next();
    lock.lock();
    if (seeks != seeks_ || stopping_)
        return;
    if (frame) {
        // A server that came back goes on where it is by now, or begins anew.
        const bool is_back = std::exchange(attempts_, 0) > 0;
        figures_.reconnections += is_back;
        if (is_back && frame->main.info.index <= newest_)
            reel_ = std::make_shared<FrameReel>(ring_options);
        deliver(std::move(*frame));
        return;
    }
    truncation_ = feed_->truncation();
    // A stream that ends in the same place again was cut when it was recorded.
    const bool is_cut_again = attempts_ == 0 && std::exchange(cut_at_, newest_) == newest_;
    if (is_live_ && (attempts_ > 0 || !truncation_.empty()) && !is_cut_again)
        return wait_to_try_again(lock);
    ended_ = true;
    if (is_live_)
        hang_up(lock);
}

bool FrameLoader::has_transfer(const std::string& name) const {
    return std::ranges::find(transfers_, name) != transfers_.end();
}

std::optional<double> FrameLoader::seconds() const {
    if (summary_.frames)
        return double(*summary_.frames) / first_.frames_per_second;
    return summary_.seconds;
}

LoaderState FrameLoader::state() const {
    const std::lock_guard lock(mutex_);
    return {reel_, ended_, attempts_, failure_ != nullptr};
}

void FrameLoader::passed(const FrameReel& reel, std::size_t frames) {
    {
        const std::lock_guard lock(mutex_);
        if (&reel != reel_.get())
            return;
        ahead_ -= std::min(ahead_, frames);
    }
    changed_.notify_all();
}

void FrameLoader::seek(std::int64_t frame) {
    {
        const std::lock_guard lock(mutex_);
        wanted_first_ = frame;
        reel_ = std::make_shared<FrameReel>(ring_options);
        ahead_ = 0;
        ++seeks_;
        ended_ = false;
        failure_ = nullptr;
        attempts_ = 0;
    }
    changed_.notify_all();
}

std::string FrameLoader::truncation() const {
    const std::lock_guard lock(mutex_);
    return truncation_;
}

void FrameLoader::rethrow() const {
    std::exception_ptr failure;
    {
        const std::lock_guard lock(mutex_);
        failure = failure_;
    }
    if (failure)
        std::rethrow_exception(failure);
}

}  // namespace equistream
