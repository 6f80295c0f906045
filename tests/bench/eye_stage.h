#pragma once
/// A sphere of the bundled scene and an eye half an IPD beside its centre, each with its depth: what benches of one
/// eye are made of.
#include "bench_scene.h"

#include <client/warp/view.h>
#include <equistream/bound.h>

namespace equistream::bench {

struct EyeStage {
    EyeStage(const EquirectCamera& source_camera, const PerspectiveCamera& eye_camera)
        : sphere(source_camera), view(eye_camera) {
        BenchScene& scene = *bench_scene("pavilion");
        const Pose head = scene.description.camera_path.at(0);
        source_pose = {head.position_m, {1, 0, 0, 0}};
        eye_pose = {eye_position(head, Eye::left, default_ipd_m), head.orientation};
        scene.depth.cast(sphere, source_pose, source_depth_m.view());
        scene.depth.cast(view, eye_pose, eye_depth_m.view());
        for (int y = 0; y < sphere.height; ++y)
            for (int x = 0; x < sphere.width; ++x)
                for (int c = 0; c < 3; ++c)
                    rgb.pixel(x, y)[c] = static_cast<std::uint8_t>(x * (c + 1) + y);
    }
    SourceView source() const {
        return {.rgb = rgb.view(),
                .camera = sphere,
                .pose = source_pose,
                .depth_m = source_depth_m.view(),
                .box_radius_m = head_box_radius_centre(0, default_ipd_m)};
    }
    EyeView eye() const { return {.camera = view, .pose = eye_pose, .depth_m = eye_depth_m.view()}; }

    EquirectCamera sphere;
    PerspectiveCamera view;
    Pose source_pose, eye_pose;
    ByteImage rgb{sphere.width, sphere.height, 3};
    FloatImage source_depth_m{sphere.width, sphere.height, 1};
    FloatImage eye_depth_m{view.width, view.height, 1};
};

}  // namespace equistream::bench
