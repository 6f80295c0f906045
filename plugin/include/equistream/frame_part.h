#pragma once
/// One frame rendered by several programs.
#include <cstdint>

namespace equistream {

/// How many parts a frame may have.
inline constexpr std::uint32_t max_frame_parts = 65536;

/// Which tiles of every frame are a program's own: tiles `number`, `number + count` and so on, counted from 1.
struct FramePart {
    std::uint32_t number = 0;  ///< from 1; 0: none of them, frames are put together from all
    std::uint32_t count = 0;   ///< 0: frames are rendered whole

    bool is_one() const { return number > 0; }
    bool is_put_together() const { return count > 0 && number == 0; }
};

}  // namespace equistream
