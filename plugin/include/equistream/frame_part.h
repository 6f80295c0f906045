#pragma once
/// Rendering one frame in parts, each by a program of its own.
#include <cstdint>

namespace equistream {

/// Most parts of a frame.
inline constexpr std::uint32_t max_frame_parts = 65536;

/// The tiles of every frame that one program renders: tiles `number`, `number + count` and so on, counted from 1.
struct FramePart {
    std::uint32_t number = 0;  ///< 1 to count; 0: renders none, assembles frames from all parts
    std::uint32_t count = 0;   ///< parts of each frame, at most max_frame_parts; 0: frames are rendered whole

    bool is_one() const { return number > 0; }
    bool is_put_together() const { return count > 0 && number == 0; }
};

}  // namespace equistream
