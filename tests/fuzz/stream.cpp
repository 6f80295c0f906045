/// A coded stream in any container, read to its end.
#include "stream/synthetic.h"
#include "target.h"

namespace equistream::fuzz {

namespace {

void read(Bytes bytes) {
    StreamReader reader(scratch_file("stream", bytes).string());
    while (const auto picture = reader.next())
        require(picture->rgb.width() > 0 && picture->rgb.width() <= max_image_side &&
                    picture->rgb.height() <= max_image_side,
                "sizes are limited");
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

Seeds seeds() {
    return {coded("a.mp4", Codec::h264, true),   coded("a.mkv", Codec::h265, false),
            coded("a.ts", Codec::h264, false),   coded("a.nut", Codec::h264, false),
            coded("a.h264", Codec::h264, false), coded("a.h265", Codec::h265, false)};
}

}  // namespace

const Target stream_target{"stream", read, seeds, 500};

}  // namespace equistream::fuzz
