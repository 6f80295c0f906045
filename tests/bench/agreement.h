#pragma once
/// How near a fast engine's pictures are to the slow reference's, to stand beside its time.
#include <tests/support/references/plain_engines.h>

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace equistream::bench {

/// Of RGB where both have colour.
inline double psnr_db(const EyePicture& found, const EyePicture& reference) {
    double squares = 0;
    std::int64_t samples = 0;
    for (int y = 0; y < found.rgba.height(); ++y)
        for (int x = 0; x < found.rgba.width(); ++x) {
            if (*found.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap) ||
                *reference.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap))
                continue;
            for (int c = 0; c < 3; ++c, ++samples) {
                const double difference = found.rgba.pixel(x, y)[c] - reference.rgba.pixel(x, y)[c];
                squares += difference * difference;
            }
        }
    return squares == 0 ? std::numeric_limits<double>::infinity()
                        : 10 * std::log10(255.0 * 255 * double(samples) / squares);
}

/// "54.6 dB to the reference, 0.12 % gaps".
inline std::string agreement_label(const char* method, const SourceView& source, const EyeView& eye,
                                   const EyePicture& found) {
    const auto engine = plain::make_engine(method);
    engine->set_source(source);
    EyePicture reference;
    engine->reproject(eye, reference);
    const double pixels = double(found.rgba.width()) * found.rgba.height();
    char text[96];
    std::snprintf(text, sizeof text, "%.1f dB to the reference, %.2f %% gaps", psnr_db(found, reference),
                  100 * double(found.count(PixelOrigin::gap)) / pixels);
    return text;
}

// The machine's own limit as a peer: a copy of the same bytes.

inline void copy_bytes(benchmark::State& state, std::size_t bytes) {
    std::vector<char> from(bytes, 1), to(bytes);
    for (auto _ : state) {
        std::memcpy(to.data(), from.data(), bytes);
        benchmark::ClobberMemory();
    }
}

}  // namespace equistream::bench
