#include "recording.h"

#include <equistream/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace equistream::serve {

Recording::Recording(const std::string& file) : times_(read_send_times(file)) {
    file_ = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (file_ < 0)
        throw InputError(expected_found(file, "a file that can be read", std::strerror(errno)));
}

Recording::~Recording() {
    close(file_);
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
