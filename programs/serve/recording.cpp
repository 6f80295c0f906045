#include "recording.h"

#include <equistream/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace equistream::serve {

namespace {

class RecordingFeed : public Feed {
public:
    explicit RecordingFeed(const Recording& recording) : recording_(recording) {}

    Portion next(std::span<char> block, double elapsed_s) override {
        if (position_ == recording_.bytes()) {
            if (!recording_.loops())
                return {.ended = true};
            position_ = 0;
            round_start_s_ += recording_.duration_s();
        }
        const std::int64_t due = recording_.due_at(elapsed_s - round_start_s_);
        if (due <= position_)
            return {.again_s = next_due_s()};
        const auto wanted = std::min(std::size_t(due - position_), block.size());
        const std::size_t count = recording_.read(position_, block.first(wanted));
        if (count == 0)
            return {.problem = "the file has become shorter or cannot be read"};
        const double due_s = next_due_s();
        position_ += std::int64_t(count);
        return {.bytes = count, .due_s = due_s};
    }

private:
    double next_due_s() const { return round_start_s_ + recording_.time_of(position_); }

    const Recording& recording_;
    double round_start_s_ = 0;   // of this repetition
    std::int64_t position_ = 0;  // in the recording
};

}  // namespace

Recording::Recording(const std::string& file, bool loop) : times_(read_send_times(file)), loop_(loop) {
    if (loop && !is_matroska())
        throw InputError(expected_found(file, "Matroska for --loop, which can be read end to end again and again",
                                        "another container"));
    file_ = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (file_ < 0)
        throw InputError(expected_found(file, "a file that can be read", std::strerror(errno)));
}

Recording::~Recording() {
    close(file_);
}

std::unique_ptr<Feed> Recording::open_feed() {
    return std::make_unique<RecordingFeed>(*this);
}

std::int64_t Recording::due_at(double time_s) const {
    const auto later = std::ranges::upper_bound(times_.parts, time_s, {}, &DueBytes::time_s);
    return later == times_.parts.begin() ? 0 : std::prev(later)->end;
}

double Recording::time_of(std::int64_t offset) const {
    return std::ranges::upper_bound(times_.parts, offset, {}, &DueBytes::end)->time_s;
}

std::size_t Recording::read(std::int64_t offset, std::span<char> bytes) const {
    ssize_t count = 0;
    do
        count = pread(file_, bytes.data(), bytes.size(), offset);
    while (count < 0 && errno == EINTR);
    return count < 0 ? 0 : std::size_t(count);
}

}  // namespace equistream::serve
