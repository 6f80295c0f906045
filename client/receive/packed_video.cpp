#include "packed_video.h"

#include <algorithm>
#include <utility>

namespace equistream {

namespace {

/// The planes stay where they are, and their owner with them.
template <typename Planes>
void keep(Planes& planes, int width, int height) {
    planes.y.width = width;
    planes.y.height = height;
    for (auto* chroma : {&planes.cb, &planes.cr}) {
        chroma->width = (width + 1) / 2;
        chroma->height = (height + 1) / 2;
    }
}

}  // namespace

void keep_left_eye(DecodedPicture& picture, StereoPacking packing) {
    // Of even sides, as planes with half the samples of colour have to be.
    int& halved = packing == StereoPacking::top_bottom ? picture.height : picture.width;
    halved = std::max(1, halved / 4 * 2);
    if (!picture.yuv.empty())
        keep(picture.yuv.planes, picture.width, picture.height);
    if (!picture.pq.empty())
        keep(picture.pq.planes, picture.width, picture.height);
    if (picture.rgb.empty())
        return;
    ByteImage left(picture.width, picture.height, 3);
    for (int y = 0; y < left.height(); ++y)
        std::copy_n(picture.rgb.pixel(0, y), 3 * left.width(), left.pixel(0, y));
    picture.rgb = std::move(left);
}

}  // namespace equistream
