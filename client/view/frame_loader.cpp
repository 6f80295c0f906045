#include "frame_loader.h"

#include <equistream/error.h>

#include <utility>

namespace equistream {

FrameLoader::FrameLoader(std::string source, FeedOptions options)
    : source_(std::move(source)), options_(std::move(options)) {
    options_.interrupted = [this] {
        const std::lock_guard lock(mutex_);
        return stopping_;
    };
    feed_ = open_feed(source_, options_);
    std::optional<ReceivedFrame> frame = feed_->next();
    if (!frame)
        throw InputError(expected_found(source_, "frames", feed_->truncation().empty() ? "none" : feed_->truncation()));
    first_ = frame->main.info;
    wanted_first_ = first_.index;
    last_index_ = first_.index;
    ready_.push_back({std::make_shared<const ReceivedFrame>(std::move(*frame)), feed_->fraction_done().value_or(0)});
    thread_ = std::thread([this] { run(); });
}

FrameLoader::~FrameLoader() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void FrameLoader::run() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        if (ended_ || failure_ || ready_.size() >= most_ready) {
            changed_.wait(lock);
            continue;
        }
        const unsigned seeks = seeks_;
        const bool jumped = opened_for_ != seeks;
        try {
            read(lock);
        } catch (...) {
            if (!lock.owns_lock())
                lock.lock();
            if (seeks != seeks_)
                continue;  // nobody waits for what failed
            // A folder has no frames there; a stream says so by its end.
            ended_ = jumped && wanted_first_ > first_.index;
            if (!ended_)
                failure_ = std::current_exception();
        }
    }
}

void FrameLoader::read(std::unique_lock<std::mutex>& lock) {
    const unsigned seeks = seeks_;
    FeedOptions options = options_;
    options.first_frame = wanted_first_;
    lock.unlock();
    const bool jumped = opened_for_ != seeks;
    if (jumped) {
        feed_.reset();
        feed_ = open_feed(source_, options);
        opened_for_ = seeks;
    }
    std::optional<ReceivedFrame> frame = feed_->next();
    lock.lock();
    if (seeks != seeks_)
        return;
    if (!frame) {
        ended_ = true;
        truncation_ = feed_->truncation();
        return;
    }
    const std::int64_t index = frame->main.info.index;
    has_gaps_ = has_gaps_ || (!jumped && index > last_index_ + 1);
    last_index_ = index;
    ready_.push_back({std::make_shared<const ReceivedFrame>(std::move(*frame)), feed_->fraction_done().value_or(0)});
}

void FrameLoader::rethrow() const {
    if (failure_ && ready_.empty())
        std::rethrow_exception(failure_);
}

SharedFrame FrameLoader::due(double time_s) {
    SharedFrame found;
    {
        const std::lock_guard lock(mutex_);
        rethrow();
        while (!ready_.empty() && ready_.front().frame->main.info.time_s <= time_s) {
            found = std::move(ready_.front().frame);
            fraction_done_ = ready_.front().fraction_done;
            ready_.pop_front();
        }
    }
    if (found)
        changed_.notify_all();
    return found;
}

bool FrameLoader::is_ready() const {
    const std::lock_guard lock(mutex_);
    return !ready_.empty();
}

SharedFrame FrameLoader::next() {
    SharedFrame found;
    {
        const std::lock_guard lock(mutex_);
        rethrow();
        if (ready_.empty())
            return nullptr;
        found = std::move(ready_.front().frame);
        fraction_done_ = ready_.front().fraction_done;
        ready_.pop_front();
    }
    changed_.notify_all();
    return found;
}

void FrameLoader::seek(std::int64_t frame) {
    {
        const std::lock_guard lock(mutex_);
        wanted_first_ = frame;
        ready_.clear();
        ++seeks_;
        ended_ = false;
        failure_ = nullptr;
    }
    changed_.notify_all();
}

bool FrameLoader::has_gaps() const {
    const std::lock_guard lock(mutex_);
    return has_gaps_;
}

bool FrameLoader::at_end() const {
    const std::lock_guard lock(mutex_);
    return ended_ && ready_.empty();
}

double FrameLoader::fraction_done() const {
    const std::lock_guard lock(mutex_);
    return fraction_done_;
}

std::string FrameLoader::truncation() const {
    const std::lock_guard lock(mutex_);
    return truncation_;
}

}  // namespace equistream
