#pragma once
/// How alike two pictures of an eye are.
#include <tests/unit/client/analytic_scene.h>

#include <cmath>

namespace equistream::test {

/// Where both show something, in dB of 255; infinite where there is no such place.
inline double psnr_where_seen(const EyePicture& a, const EyePicture& b) {
    double squares = 0;
    std::int64_t samples = 0;
    for (int y = 0; y < a.rgba.height(); ++y)
        for (int x = 0; x < a.rgba.width(); ++x) {
            if (a.origin.pixel(x, y)[0] == 0 || b.origin.pixel(x, y)[0] == 0)
                continue;
            for (int c = 0; c < 3; ++c)
                squares += std::pow(a.rgba.pixel(x, y)[c] - b.rgba.pixel(x, y)[c], 2);
            samples += 3;
        }
    return squares == 0 ? infinity : 10 * std::log10(255.0 * 255.0 * double(samples) / squares);
}

inline std::int64_t other_origins(const EyePicture& a, const EyePicture& b) {
    std::int64_t others = 0;
    for (std::size_t i = 0; i < a.origin.samples().size(); ++i)
        others += a.origin.samples()[i] != b.origin.samples()[i];
    return others;
}

}  // namespace equistream::test
