#pragma once
/// A stream some of whose frame numbers are missing: with poses, or as ordinary video of variable frame rate.
#include <equistream/stream.h>

#include <cstdint>
#include <string>

namespace equistream::testing {

/// Frames 0 to 5, 65, 125 and 185 at 60 a second.
inline void write_gapped_stream(const std::string& file, bool posed) {
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.frames_per_second = 60;
    settings.tagged = posed;
    settings.tracks = {{TrackRole::main, 128, 64}};
    StreamWriter writer(file, settings);
    for (const std::int64_t number : {0, 1, 2, 3, 4, 5, 65, 125, 185}) {
        FrameInfo info;
        info.index = number;
        info.frames_per_second = 60;
        info.time_s = double(number) / 60;
        info.camera = EquirectCamera{128, 64, {}};
        writer.write(TrackRole::main, ByteImage(128, 64, 3, 99).view(), info);
    }
    writer.finish();
}

}  // namespace equistream::testing
