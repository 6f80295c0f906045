/// Frame data out of a coded picture (SEI payload).
#include "target.h"

#include <equistream/stream.h>

namespace equistream::fuzz {

namespace {

void read(Bytes bytes) {
    const auto tagged = decode_frame_info(bytes);
    if (!tagged)
        return;
    const FrameInfo& info = tagged->info;
    require(width_of(info.camera) <= max_image_side && height_of(info.camera) <= max_image_side, "sizes are limited");
    const auto payload = encode_frame_info(tagged->role, info, tagged->position);
    const auto again = decode_frame_info(payload);
    require(again && encode_frame_info(again->role, again->info, again->position) == payload,
            "what was accepted can be written and read again");
}

Seeds seeds() {
    FrameInfo sphere;
    sphere.index = 7;
    sphere.camera = EquirectCamera{960, 480, {-2.5, 3.0, -0.7, 1.1}};
    sphere.scene = "waves";
    sphere.host = "synthetic 1";
    sphere.crf = 28.5f;
    FrameInfo view;
    view.camera = PerspectiveCamera{640, 360, 1.25};
    view.eye = Eye::left;
    view.lock = AxisLock::path;
    FrameInfo depth = sphere;
    depth.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 0.4, true}, 12};
    FrameInfo moving = sphere;
    moving.moving = {
        {{{{1, 0, -2}, {0, 3, 0}}, {{0, 9, 0}, {0, 0, 0}}}, 0.8f, 1.5f, {{7, 940, 960}, {8, 0, 12}, {8, 900, 960}}},
        {{}, 2, 2, {{470, 3, 4}}}};
    FrameInfo patches;
    patches.camera = EquirectCamera{64, 32, {}};
    patches.patches = PatchAtlas{64, 32, 16, {}, {{0.05, 0, 0}}, 2, 2, {{0, 1, 0, true}, {0, 1, 1, true}, {}, {}}};
    return {encode_frame_info(TrackRole::patches, patches), encode_frame_info(TrackRole::main, moving, {8, 90}),
            encode_frame_info(TrackRole::main, sphere, {7, 90}), encode_frame_info(TrackRole::small, view),
            encode_frame_info(TrackRole::depth, depth, {3, 0})};
}

}  // namespace

const Target frame_data_target{"frame_data", read, seeds, 50000, damage_frame_data};

}  // namespace equistream::fuzz
