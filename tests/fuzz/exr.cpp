/// An EXR frame, ours or anybody's.
#include "target.h"

#include <equistream/sequence.h>
#include <tests/unit/plugin/export/frame_fixture.h>

namespace equistream::fuzz {

namespace {

void read(Bytes bytes) {
    const Frame frame = read_exr(scratch_file("frame.exr", bytes));
    const int width = width_of(frame.info.camera), height = height_of(frame.info.camera);
    require(!frame.planes.empty() || !frame.ids.empty(), "there is a plane");
    for (const auto& [name, plane] : frame.planes)
        require(plane.width() == width && plane.height() == height, "planes have the camera's size");
    for (const auto& [name, plane] : frame.ids)
        require(plane.width() == width && plane.height() == height, "planes have the camera's size");
}

std::vector<std::uint8_t> written(const Frame& frame, const ExrWriteOptions& options) {
    const std::filesystem::path file = scratch_file("seed.exr", {});
    write_exr(file, frame, options);
    return bytes_of_file(file);
}

Seeds seeds() {
    Frame colour_only = testing::test_frame(7, 20);
    std::erase_if(colour_only.planes, [](const auto& plane) { return plane.first != "colour"; });
    colour_only.ids.clear();
    return {written(testing::test_frame(12, 18), {}), written(testing::test_frame(5, 3), {.single_part = true}),
            written(colour_only, {})};
}

}  // namespace

const Target exr_target{"exr", read, seeds, 14000};

}  // namespace equistream::fuzz
