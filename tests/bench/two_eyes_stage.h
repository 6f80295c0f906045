#pragma once
/// Two 1920x1080 eyes, an IPD apart around the centre of a 3840x1920 sphere, with all depths; the head box is the
/// scene's.
#include "bench_scene.h"
#include "big_views.h"

#include <equistream/bound.h>

#include <array>

namespace equistream::bench {

struct TwoEyesStage {
    explicit TwoEyesStage(BenchScene& scene)
        : box_radius_m(head_box_radius_centre(scene.description.head_radius_m, default_ipd_m)) {
        const Pose head = scene.description.camera_path.at(0);
        source_pose = {head.position_m, {1, 0, 0, 0}};
        scene.depth.cast(big_sphere, source_pose, source_depth_m.view());
        for (std::size_t i = 0; i < 2; ++i) {
            eye_poses[i] = {eye_position(head, i == 0 ? Eye::left : Eye::right, default_ipd_m), head.orientation};
            scene.depth.cast(big_view, eye_poses[i], eye_depths_m[i].view());
        }
    }
    /// Without colour.
    SourceView source_of_depth() const {
        return {
            .camera = big_sphere, .pose = source_pose, .depth_m = source_depth_m.view(), .box_radius_m = box_radius_m};
    }
    SourceView source() const {
        SourceView view = source_of_depth();
        view.rgb = rgba.view();
        return view;
    }
    EyeView eye(std::size_t i) const { return {big_view, eye_poses[i], eye_depths_m[i].view()}; }

    double box_radius_m;
    ByteImage rgba = big_picture(4);
    BigPlanes planes;
    FloatImage source_depth_m{big_sphere.width, big_sphere.height, 1};
    std::array<FloatImage, 2> eye_depths_m = {FloatImage(big_view.width, big_view.height, 1),
                                              FloatImage(big_view.width, big_view.height, 1)};
    Pose source_pose;
    std::array<Pose, 2> eye_poses;
};

}  // namespace equistream::bench
