#pragma once
/// Frames that follow each other.
#include <cstdint>
#include <span>

namespace equistream::cli {

/// The first number from `first` on that is not there; `frames` ascend.
inline std::int64_t first_missing(std::span<const std::int64_t> frames, std::int64_t first) {
    for (const std::int64_t index : frames)
        first += index == first ? 1 : 0;
    return first;
}

}  // namespace equistream::cli
