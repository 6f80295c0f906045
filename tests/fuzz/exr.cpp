/// EXR files: frames of ours, and of any other renderer.
#include "target.h"

#include <equistream/sequence.h>
#include <host-adapters/import/import.h>
#include <tests/unit/plugin/export/frame_fixture.h>

#include <cmath>

namespace equistream::fuzz {

// A frame, ours or anybody's.

namespace {

void take_frame(Bytes bytes) {
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

Seeds frame_seeds() {
    Frame colour_only = testing::test_frame(7, 20);
    std::erase_if(colour_only.planes, [](const auto& plane) { return plane.first != "colour"; });
    colour_only.ids.clear();
    return {written(testing::test_frame(12, 18), {}), written(testing::test_frame(5, 3), {.single_part = true}),
            written(colour_only, {})};
}

}  // namespace

const Target exr_target{"exr", take_frame, frame_seeds, 14000};

// Another renderer's file, from its headers to a converted frame.

namespace {

void take_foreign(Bytes bytes) {
    files::ImportSettings settings;
    settings.sources = {scratch_file("foreign.0001.exr", bytes).string()};
    settings.camera = "equirect";
    files::ImportPlan plan = files::make_plan(settings);
    require(!plan.table().empty(), "there is something to say");
    files::ForeignExr file(settings.sources.front());
    const int width = width_of(plan.camera), height = height_of(plan.camera);
    for (const files::PlannedView& view : plan.views) {
        for (const files::MappedPlane& plane : view.map.planes)
            if (!plane.channels.front().is_id)
                file.decode(plane.channels);
        const files::Conversion conversion{plan.conventions, plan.camera, {}, {}, {}, plan.colour_to_rec709};
        const Frame frame = files::convert_frame({&file}, view.map, conversion, {}, plan.notes);
        for (const auto& [name, plane] : frame.planes)
            require(plane.width() == width && plane.height() == height, "planes have the camera's size");
        for (const auto& [name, plane] : frame.ids)
            require(plane.width() == width && plane.height() == height, "planes have the camera's size");
    }
}

Seeds foreign_seeds() {
    const std::filesystem::path file = scratch_file("seed.exr", {});
    Seeds found;
    for (const bool single_part : {false, true}) {
        Frame frame = testing::test_frame(single_part ? 5 : 12, single_part ? 3 : 18);
        for (float& distance_m : frame.planes.at("depth").samples())
            distance_m = std::abs(distance_m);
        write_exr(file, frame, {.single_part = single_part});
        found.push_back(bytes_of_file(file));
    }
    return found;
}

}  // namespace

const Target foreign_exr_target{"foreign_exr", take_foreign, foreign_seeds, 6000};

}  // namespace equistream::fuzz
