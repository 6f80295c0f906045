#include "decoded_pictures.h"

#include <glm/vec2.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

namespace equistream {

namespace {

/// Sums over squares of four, so that nothing is rounded.
constexpr int one_step = 4;

struct Squares {
    int width = 0, height = 0;
    Image<int> luma;       ///< sums
    FloatImage inverse_m;  ///< 1/r, NaN for no surface

    Squares(ImageView<const float> depth_m, ImageView<const std::uint8_t> picture_luma)
        : width(depth_m.width / 2), height(depth_m.height / 2), luma(width, height, 1), inverse_m(width, height, 1) {
        tbb::parallel_for(0, height, [&](int y) {
            const std::uint8_t* upper = picture_luma.row(2 * y);
            const std::uint8_t* lower = picture_luma.row(2 * y + 1);
            const float* depth = depth_m.row(2 * y);
            for (int x = 0; x < width; ++x) {
                *luma.pixel(x, y) = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
                *inverse_m.pixel(x, y) = 1 / depth[2 * x];
            }
        });
    }
};

constexpr int outside = -1;

/// Places along one axis: of the square before, the own, the next and the one behind that, towards `step`.
std::array<int, 4> places(int own, int step, int count, bool closes) {
    std::array<int, 4> found{};
    for (int i = 0; i < 4; ++i) {
        const int place = own + (i - 1) * step;
        found[std::size_t(i)] = closes ? (place + count) % count : place < 0 || place >= count ? outside : place;
    }
    return found;
}

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

ByteImage luma_of(ImageView<const std::uint8_t> rgb) {
    ByteImage luma(rgb.width, rgb.height, 1);
    tbb::parallel_for(0, rgb.height, [&](int y) {
        const std::uint8_t* c = rgb.row(y);
        for (int x = 0; x < rgb.width; ++x, c += 3)
            *luma.pixel(x, y) = std::uint8_t(
                std::lround(16 + bt709::luma_scale * (bt709::kr * c[0] + bt709::kg * c[1] + bt709::kb * c[2])));
    });
    return luma;
}

ByteImage luma_of(const PqView& planes) {
    ByteImage luma(planes.y.width, planes.y.height, 1);
    tbb::parallel_for(0, luma.height(), [&](int y) {
        std::transform(planes.y.row(y), planes.y.row(y) + planes.y.width, luma.pixel(0, y),
                       [](std::uint16_t sample) { return std::uint8_t(sample >> 2); });
    });
    return luma;
}

FloatImage guided_depth(ImageView<const float> depth_m, ImageView<const std::uint8_t> luma,
                        const DepthAgreement& agreement, bool closes) {
    assert(depth_m.width == luma.width && depth_m.height == luma.height && depth_m.width % 2 == 0 &&
           depth_m.height % 2 == 0);
    const Squares squares(depth_m, luma);
    FloatImage guided_m(depth_m.width, depth_m.height, 1);
    tbb::parallel_for(0, depth_m.height, [&](int y) {
        const auto rows = places(y / 2, y % 2 == 0 ? -1 : 1, squares.height, false);
        for (int x = 0; x < depth_m.width; ++x) {
            const auto columns = places(x / 2, x % 2 == 0 ? -1 : 1, squares.width, closes);
            const int here = 4 * luma.row(y)[x];
            int nearest = std::abs(here - *squares.luma.pixel(columns[1], rows[1])) - one_step;
            const float* chosen = &depth_m.row(2 * rows[1])[2 * columns[1]];
            for (const auto& [across, down] : {std::array{1, 0}, {0, 1}, {1, 1}}) {
                // Along the row, the column or the diagonal.
                const auto place = [&, across = across, down = down](int i) {
                    return std::pair(columns[std::size_t(1 + across * i)], rows[std::size_t(1 + down * i)]);
                };
                const auto is_inside = [&](int i) { return place(i).first != outside && place(i).second != outside; };
                const auto at = [&](int i) {
                    return is_inside(i) ? *squares.inverse_m.pixel(place(i).first, place(i).second)
                                        : std::numeric_limits<float>::quiet_NaN();
                };
                // With nothing before or behind the two, in a corner, no slope tells whether they are one surface.
                if (!is_inside(1) || !(is_inside(-1) || is_inside(2)))
                    continue;
                const auto [column, row] = place(1);
                const int off = std::abs(here - *squares.luma.pixel(column, row));
                if (off > nearest || agreement.connected(at(-1), at(0), at(1), at(2)))
                    continue;
                nearest = off - 1;
                chosen = &depth_m.row(2 * row)[2 * column];
            }
            *guided_m.pixel(x, y) = *chosen;
        }
    });
    return guided_m;
}

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
