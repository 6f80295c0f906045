#pragma once
/// What a headset would ask for: a 3840x1920 sphere and 1920x1080 eyes, with pictures of no scene.
#include "bench_scene.h"

#include <equistream/bound.h>

#include <client/warp/view.h>

#include <array>
#include <random>

namespace equistream::bench {

inline constexpr EquirectCamera big_sphere{3840, 1920, {}};
inline constexpr PerspectiveCamera big_view{1920, 1080, pi / 2};

/// White noise: the hardest to interpolate.
inline ByteImage noise(int width, int height, int channels) {
    ByteImage picture(width, height, channels);
    std::minstd_rand random(1);
    for (std::uint8_t& sample : picture.samples())
        sample = static_cast<std::uint8_t>(random() >> 16);
    return picture;
}

inline ByteImage big_picture(int channels) {
    return noise(big_sphere.width, big_sphere.height, channels);
}

/// A decoder's planes.
struct BigPlanes {
    ByteImage y = big_picture(1);
    ByteImage cb = noise(big_sphere.width / 2, big_sphere.height / 2, 1);
    ByteImage cr = noise(big_sphere.width / 2, big_sphere.height / 2, 1);

    YuvView view() const { return {y.view(), cb.view(), cr.view()}; }
};

// A sphere of the bundled scene and an eye half an IPD beside its centre, each with its depth: what benches of one
// eye are made of.

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

// Two 1920x1080 eyes, an IPD apart around the centre of a 3840x1920 sphere, with all depths; the head box is the
// scene's.

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
