#include "packed_video.h"

#include <glm/vec2.hpp>

#include <algorithm>
#include <utility>

namespace equistream {

namespace {

/// The part of them that begins at (x, y). They stay where they are, and their owner with them.
template <typename Planes>
void keep(Planes& planes, glm::ivec2 from, glm::ivec2 size) {
    const auto keep_plane = [](auto& plane, glm::ivec2 at, glm::ivec2 kept) {
        plane.data = plane.pixel(at.x, at.y);
        plane.width = kept.x;
        plane.height = kept.y;
    };
    keep_plane(planes.y, from, size);
    for (auto* chroma : {&planes.cb, &planes.cr})
        keep_plane(*chroma, from / 2, (size + 1) / 2);
}

/// The part of `both` that begins at `from`, which is even; of its planes those of `picture`.
void keep(DecodedPicture& picture, const ByteImage& both, glm::ivec2 from, glm::ivec2 size) {
    picture.width = size.x;
    picture.height = size.y;
    if (!picture.yuv.empty())
        keep(picture.yuv.planes, from, size);
    if (!picture.pq.empty())
        keep(picture.pq.planes, from, size);
    if (both.empty())
        return;
    picture.rgb = ByteImage(size.x, size.y, 3);
    for (int y = 0; y < size.y; ++y)
        std::copy_n(both.pixel(from.x, from.y + y), 3 * size.x, picture.rgb.pixel(0, y));
}

}  // namespace

DecodedPicture split_eyes(DecodedPicture& picture, StereoPacking packing) {
    const bool stacked = packing == StereoPacking::top_bottom;
    // Of even sides, as planes with half the samples of colour have to be; the second half begins where it would
    // without that, at an even sample too.
    const int both = stacked ? picture.height : picture.width, half = std::max(1, both / 4 * 2),
              second = both / 2 / 2 * 2;
    const glm::ivec2 size = stacked ? glm::ivec2(picture.width, half) : glm::ivec2(half, picture.height);
    const ByteImage both_rgb = std::exchange(picture.rgb, {});
    DecodedPicture right = picture;
    right.decode_ms = right.convert_ms = 0;  // which the left one tells of
    right.bytes = 0;
    keep(right, both_rgb, stacked ? glm::ivec2(0, second) : glm::ivec2(second, 0), size);
    keep(picture, both_rgb, {0, 0}, size);
    return right;
}

}  // namespace equistream
