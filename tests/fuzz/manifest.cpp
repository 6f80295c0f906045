/// manifest.json of a sequence's folder.
#include "target.h"

#include <equistream/sequence.h>
#include <tests/unit/plugin/export/frame_fixture.h>

namespace equistream::fuzz {

namespace {

void read(Bytes bytes) {
    const Manifest found = read_manifest(scratch_file("manifest.json", bytes).parent_path());
    const FrameInfo& info = found.shared;
    require(width_of(info.camera) >= 1 && width_of(info.camera) <= max_image_side, "sizes are limited");
    require(std::isfinite(info.time_s) && std::isfinite(info.exposure), "numbers are finite");
}

Seeds seeds() {
    Manifest manifest;
    manifest.shared = testing::test_info(960, 480);
    manifest.planes = {"colour", "depth"};
    manifest.command = "equistream render \"a b\"";
    manifest.fingerprint = "0123abcd";
    const std::filesystem::path folder = scratch_file("manifest.json", {}).parent_path();
    Seeds seeds;
    for (const Camera& camera : {Camera(EquirectCamera{960, 480, {}}), Camera(PerspectiveCamera{640, 360, 1.5})}) {
        manifest.shared.camera = camera;
        write_manifest(folder, manifest);
        seeds.push_back(bytes_of_file(folder / "manifest.json"));
    }
    return seeds;
}

}  // namespace

const Target manifest_target{"manifest", read, seeds, 15000};

}  // namespace equistream::fuzz
