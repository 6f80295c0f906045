#include "frame_loader.h"

#include <equistream/error.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace equistream {

namespace {

/// Planes of video are of 4:2:0: half a sample of colour for each of light, of two bytes in PQ.
std::size_t bytes_of(const ReceivedPicture& picture) {
    const std::size_t pixels = std::size_t(picture.width()) * std::size_t(picture.height());
    const std::size_t colour = !picture.pq.empty()    ? 3 * pixels
                               : !picture.yuv.empty() ? 3 * pixels / 2
                                                      : picture.rgb.samples().size_bytes();
    return colour + picture.depth_m.samples().size_bytes() + picture.specular.samples().size_bytes() +
           picture.virtual_depth_m.samples().size_bytes();
}

std::size_t bytes_of(const ReceivedFrame& frame) {
    std::size_t sum = bytes_of(frame.main);
    for (const auto* other : {&frame.base, &frame.small, &frame.hidden, &frame.patches, &frame.right})
        sum += *other ? bytes_of(**other) : 0;
    for (const ReceivedPicture& view : frame.depth_views)
        sum += bytes_of(view);
    return sum;
}

/// In one refresh no more time passes than frames were read ahead: three refreshes at 60 a second. Fewer are read ahead
/// where so many would not fit into the memory allowed: refreshes then wait for the next one.
std::size_t frames_ahead(const ReceivedFrame& first, std::size_t max_bytes) {
    constexpr double ahead_s = 0.05, most = 50;
    constexpr std::size_t least = 3;
    const auto wanted = std::size_t(std::ceil(std::min(ahead_s * first.main.info.frames_per_second, most)));
    const std::size_t fitting = max_bytes / std::max<std::size_t>(1, bytes_of(first));
    return std::max(least, std::min(wanted, fitting));
}

/// Beside those that are read ahead. Of a live source all of it is for the play-out delay: with them it is a quarter of
/// a second at 30 frames/s, and some.
constexpr std::size_t room_beside = 9;

/// Before the nth attempt to reach a server again.
std::chrono::duration<double> pause_before(int attempt) {
    constexpr double first_s = 0.25, longest_s = 4;
    return std::chrono::duration<double>(std::min(longest_s, first_s * double(1 << std::min(attempt - 1, 10))));
}

}  // namespace

FrameLoader::FrameLoader(std::string source, FeedOptions options, std::size_t max_ahead_bytes)
    : source_(std::move(source)), options_(std::move(options)) {
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
    can_jump_ = !is_live_ && !is_pipe(source_);
    transfers_ = feed_->transfers();
    summary_ = feed_->summary();
    if (!is_live_)  // to jump may take longer
        options_.first_frame_limit_s = std::numeric_limits<double>::infinity();
    first_ = frame.main.info;
    is_posed_ = frame.posed;
    wanted_.first = first_.index;
    max_ahead_ = frames_ahead(frame, is_live_ ? std::numeric_limits<std::size_t>::max() : max_ahead_bytes);
    reel_ = new_reel();
    deliver(std::move(frame));
    thread_ = std::thread([this] { run(); });
}

std::shared_ptr<FrameReel> FrameLoader::new_reel() const {
    return std::make_shared<FrameReel>(FrameRingOptions{.kept = 1, .capacity = max_ahead_ + room_beside});
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
    return !ended_ && !failure_ && (is_live_ || ahead_ < max_ahead_);
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
    const FrameStamp stamp{info.index, info.time_s, info.head, now_s(), frame.ordinal.value_or(info.index)};
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

/// Whether nobody waits any more for what is looked for.
bool FrameLoader::is_outdated() const {
    const std::lock_guard lock(mutex_);
    return stopping_ || seeks_ != opened_for_;
}

void FrameLoader::go_to(std::int64_t frame) {
    if (feed_ && !is_live_ && feed_->seek(frame))
        return;
    FeedOptions options = options_;
    if (!is_live_)
        options.first_frame = frame;
    feed_.reset();
    feed_bytes_ = 0;
    feed_ = open_feed(source_, options);
}

std::optional<ReceivedFrame> FrameLoader::find(const Wanted& wanted) {
    following_.reset();
    go_to(wanted.first);
    std::optional<ReceivedFrame> found = feed_->next();
    const bool is_earlier = found && wanted.before_s && found->main.info.time_s < *wanted.before_s;
    return !wanted.before_s || is_earlier || wanted.first <= first_.index ? std::move(found) : find_last_before(wanted);
}

/// Nobody knows which numbers there are: looks for it ever farther back. Twice as far, so that of dense frames before a
/// gap no more are read than the gap has numbers.
std::optional<ReceivedFrame> FrameLoader::find_last_before(const Wanted& wanted) {
    constexpr std::int64_t farther = 2;
    for (std::int64_t back = farther; !is_outdated(); back *= farther) {
        const std::int64_t from = std::max(first_.index, wanted.first - back);
        go_to(from);
        std::optional<ReceivedFrame> last, found = feed_->next();
        while (found && found->main.info.time_s < *wanted.before_s && !is_outdated()) {
            last = std::exchange(found, std::nullopt);
            found = feed_->next();
        }
        if (last)
            following_ = std::move(found);
        if (last || from == first_.index)
            return last ? std::move(last) : std::move(found);
    }
    return std::nullopt;
}

void FrameLoader::read(std::unique_lock<std::mutex>& lock) {
    const unsigned seeks = seeks_;
    const Wanted wanted = wanted_;
    lock.unlock();
    const bool has_jumped = std::exchange(opened_for_, seeks) != seeks;
    std::optional<ReceivedFrame> frame = has_jumped || !feed_ ? find(wanted)
                                         : following_         ? std::exchange(following_, std::nullopt)
                                                              : feed_->next();
    lock.lock();
    if (seeks != seeks_ || stopping_)
        return;
    if (frame) {
        // A server that came back goes on where it is by now, or begins anew.
        const bool is_back = std::exchange(attempts_, 0) > 0;
        figures_.reconnections += is_back;
        if (is_back && frame->main.info.index <= newest_)
            reel_ = new_reel();
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

void FrameLoader::seek(std::int64_t frame, std::optional<double> before_s) {
    {
        const std::lock_guard lock(mutex_);
        wanted_ = {frame, before_s};
        reel_ = new_reel();
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
