/// A coded stream in any container, read to its end.
#include "target.h"

#include <equistream/error.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <algorithm>
#include <cmath>

namespace equistream::fuzz {

namespace {

/// The first pictures of it, without a file, and as their decoders' planes.
void read_as_it_comes(Bytes bytes) {
    StreamReadOptions options;
    options.yuv = options.pq = true;
    options.read = [left = bytes](std::span<std::uint8_t> room) mutable {
        const Bytes taken = left.first(std::min({left.size(), room.size(), std::size_t(1500)}));
        std::ranges::copy(taken, room.begin());
        left = left.subspan(taken.size());
        return taken.size();
    };
    StreamReader reader("tcp://fuzz:1", options);  // nothing is opened by this name
    for (int pictures = 0; pictures < 3; ++pictures)
        if (const auto picture = reader.next())
            require(picture->depth_m.empty() != (picture->rgb.empty() && picture->yuv.empty() && picture->pq.empty()),
                    "a picture is colour or depth");
    require(!reader.newest_s(0) || std::isfinite(*reader.newest_s(0)), "a time is one");
}

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
    require(!reader.container().empty(), "a container has a name");
    if (reader.seek(0.04))
        reader.next();
    try {
        read_as_it_comes(bytes);
    } catch (const InputError&) {
        return;  // containers whose index is at their end
    }
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

/// Both eyes in each picture, of HDR: others' video.
std::vector<std::uint8_t> foreign(const char* name) {
    const synthetic::Folder folder;
    StreamSettings settings;
    settings.codec = Codec::h265;
    settings.transfer = Transfer::pq;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 64, 64}};
    settings.stereo = StereoPacking::side_by_side;
    settings.sphere.emplace();
    settings.tagged = false;
    settings.pictures = 2;
    StreamWriter writer(folder / name, settings);
    for (std::int64_t index = 0; index < 2; ++index)
        writer.write_pq(TrackRole::main, FloatImage(64, 64, 3, 0.4f).view(), synthetic::info(64, 64, index));
    writer.finish();
    return bytes_of_file(folder / name);
}

std::vector<std::uint8_t> coded_depth(const char* name, DepthCodeId code, bool halved = false) {
    const synthetic::Folder folder;
    StreamSettings settings;
    settings.preset = "ultrafast";
    const int side = halved ? 128 : 64;
    settings.tracks = {{TrackRole::main, side, side}, {TrackRole::depth, side, side, code, {}, halved}};
    settings.pictures = 2;
    StreamWriter writer(folder / name, settings);
    for (std::int64_t index = 0; index < 2; ++index) {
        FrameInfo info = synthetic::info(side, side, index);
        writer.write(TrackRole::main, synthetic::picture(side, side, index).view(), info);
        info.depth_code = DepthCodeInfo{code, {0.0315, 0.5, false}, 0};
        writer.write_depth(TrackRole::depth, FloatImage(side, side, 1, 2.5f).view(), info);
    }
    writer.finish();
    return bytes_of_file(folder / name);
}

Seeds seeds() {
    return {foreign("f.mp4"),
            coded_depth("h.mkv", DepthCodeId::w10, true),
            coded_depth("d.mkv", DepthCodeId::w10),
            coded_depth("d.ts", DepthCodeId::pece444),
            coded("a.mp4", Codec::h264, true),
            coded("a.mkv", Codec::h265, false),
            coded("a.ts", Codec::h264, false),
            coded("a.nut", Codec::h264, false),
            coded("a.h264", Codec::h264, false),
            coded("a.h265", Codec::h265, false)};
}

}  // namespace

const Target stream_target{"stream", read, seeds, 150, damage_frame_data};

}  // namespace equistream::fuzz
