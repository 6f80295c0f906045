#pragma once
/// Streams of a moving ball with its depth, for tests of depth tracks.
#include "synthetic.h"

#include <equistream/depth_code.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

namespace equistream::test {

inline constexpr int width = 192, height = 128, pictures = 8;
inline constexpr DepthRange range{0.0315, 0.75, false};

/// A floor and a sky, and before them a ball that moves with `index`.
inline FloatImage depth_of(std::int64_t index) {
    FloatImage depth_m(width, height, 1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double down = (y + 0.5 - height / 2.0) / height * pi;
            const bool ball = std::hypot(x - 60.0 - 2.0 * double(index), y - 48.0) < 20;
            depth_m.pixel(x, y)[0] = ball ? 0.75f : down > 0.02 ? float(1.6 / std::sin(down)) : HUGE_VALF;
        }
    return depth_m;
}

inline FrameInfo info_of(std::int64_t index, std::optional<DepthCodeId> code = {}) {
    FrameInfo info = synthetic::info(width, height, index);
    if (code)
        info.depth_code = DepthCodeInfo{*code, range, 0};
    return info;
}

inline StreamSettings settings_of(Codec codec, DepthCodeId code) {
    StreamSettings settings;
    settings.codec = codec;
    settings.preset = "veryfast";
    settings.gop = 4;
    settings.tracks = {{TrackRole::main, width, height}, {TrackRole::depth, width, height, code}};
    return settings;
}

inline StreamSettings halved_settings(DepthCodeId code, double crf) {
    StreamSettings settings = settings_of(Codec::h264, code);
    settings.tracks[1].halved = true;
    settings.tracks[1].crf = crf;
    return settings;
}

inline void write(const std::string& file, const StreamSettings& settings, DepthCodeId code) {
    StreamWriter writer(file, settings);
    for (std::int64_t index = 0; index < pictures; ++index) {
        writer.write(TrackRole::main, synthetic::picture(width, height, index).view(), info_of(index));
        writer.write_depth(TrackRole::depth, depth_of(index).view(), info_of(index, code));
    }
    writer.finish();
}

inline std::string bytes_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace equistream::test
