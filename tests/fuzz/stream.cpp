/// A coded stream in any container, read to its end.
#include "target.h"

#include <tests/unit/plugin/stream/synthetic.h>

namespace equistream::fuzz {

namespace {

void read(Bytes bytes) {
    StreamReader reader(scratch_file("stream", bytes).string());
    while (const auto picture = reader.next()) {
        require(picture->width > 0 && picture->width <= max_image_side && picture->height <= max_image_side,
                "sizes are limited");
        require(picture->rgb.empty() != picture->depth_m.empty(), "a picture is colour or depth");
        if (!picture->depth_m.empty() && picture->info->depth_code->code != DepthCodeId::lossless)
            for (const float r : picture->depth_m.samples())
                require(!(r < float(picture->info->depth_code->range.near_m)), "no depth is nearer than the nearest");
    }
    require(reader.truncation().find('\n') == std::string::npos, "a cut is told in one line");
}

std::vector<std::uint8_t> coded(const char* name, Codec codec, bool two_tracks) {
    synthetic::Made made = synthetic::small_stream(codec, two_tracks);
    made.pictures = 3;
    made.settings.pictures = 3;
    made.settings.gop = 2;
    made.settings.crf = 40;
    made.settings.tracks[0] = {TrackRole::main, 128, 64};
    const synthetic::Folder folder;
    synthetic::write(folder / name, made);
    return bytes_of_file(folder / name);
}

std::vector<std::uint8_t> coded_depth(const char* name, DepthCodeId code) {
    const synthetic::Folder folder;
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 64, 64}, {TrackRole::depth, 64, 64, code}};
    settings.pictures = 2;
    StreamWriter writer(folder / name, settings);
    for (std::int64_t index = 0; index < 2; ++index) {
        FrameInfo info = synthetic::info(64, 64, index);
        writer.write(TrackRole::main, synthetic::picture(64, 64, index).view(), info);
        info.depth_code = DepthCodeInfo{code, {0.0315, 0.5, false}, 0};
        writer.write_depth(TrackRole::depth, FloatImage(64, 64, 1, 2.5f).view(), info);
    }
    writer.finish();
    return bytes_of_file(folder / name);
}

Seeds seeds() {
    return {coded_depth("d.mkv", DepthCodeId::w10), coded_depth("d.ts", DepthCodeId::pece444),
            coded("a.mp4", Codec::h264, true),      coded("a.mkv", Codec::h265, false),
            coded("a.ts", Codec::h264, false),      coded("a.nut", Codec::h264, false),
            coded("a.h264", Codec::h264, false),    coded("a.h265", Codec::h265, false)};
}

}  // namespace

const Target stream_target{"stream", read, seeds, 500, damage_frame_data};

}  // namespace equistream::fuzz
