/// Another renderer's EXR file, from its headers to a converted frame.
#include "target.h"

#include <equistream/sequence.h>
#include <host-adapters/import/import.h>
#include <tests/unit/plugin/export/frame_fixture.h>

#include <cmath>

namespace equistream::fuzz {

namespace {

void read(Bytes bytes) {
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

Seeds seeds() {
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

const Target foreign_exr_target{"foreign_exr", read, seeds, 6000};

}  // namespace equistream::fuzz
