#pragma once
/// Pictures that nobody painted, for filling.
#include <client/warp/view.h>

#include <algorithm>
#include <limits>
#include <random>

namespace equistream::test {

/// Gaps of all sizes, surfaces at a few depths with steps between.
struct RandomPicture {
    EyePicture picture;
    FloatImage depth_m;

    RandomPicture(int width, int height, std::mt19937& random) {
        const auto number = [&](int end) { return std::uniform_int_distribution<int>(0, end - 1)(random); };
        picture.rgba = ByteImage(width, height, 4, 255);
        picture.origin = ByteImage(width, height, 1, std::uint8_t(PixelOrigin::source));
        depth_m = FloatImage(width, height, 1, 4.0f);
        for (std::uint8_t& byte : picture.rgba.samples())
            byte = std::uint8_t(number(256));
        for (int box = 0; box < 6; ++box) {
            const int left = number(width), top = number(height), side = 1 << number(6);
            const float depth = box == 5 ? std::numeric_limits<float>::infinity() : 0.4f * float(1 + number(9));
            const bool open = number(2) == 1;
            for (int y = top; y < std::min(top + side, height); ++y)
                for (int x = left; x < std::min(left + side, width); ++x) {
                    *depth_m.pixel(x, y) = depth + 0.01f * float(x);
                    if (open)
                        *picture.origin.pixel(x, y) = 0;
                }
        }
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if (*picture.origin.pixel(x, y) == 0)
                    std::fill_n(picture.rgba.pixel(x, y), 4, std::uint8_t{0});
    }
};

}  // namespace equistream::test
