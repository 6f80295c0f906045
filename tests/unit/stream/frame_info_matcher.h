#pragma once
#include <equistream/frame.h>

#include <gtest/gtest.h>

namespace equistream {

/// Every field bit for bit.
inline void expect_same_info(const FrameInfo& a, const FrameInfo& b) {
    EXPECT_EQ(a.index, b.index);
    EXPECT_EQ(a.time_s, b.time_s);
    EXPECT_EQ(a.frames_per_second, b.frames_per_second);
    ASSERT_EQ(a.camera.index(), b.camera.index());
    EXPECT_EQ(width_of(a.camera), width_of(b.camera));
    EXPECT_EQ(height_of(a.camera), height_of(b.camera));
    if (const auto* sphere = std::get_if<EquirectCamera>(&a.camera)) {
        const auto& range = std::get<EquirectCamera>(b.camera).range;
        EXPECT_EQ(sphere->range.longitude_min, range.longitude_min);
        EXPECT_EQ(sphere->range.longitude_max, range.longitude_max);
        EXPECT_EQ(sphere->range.latitude_min, range.latitude_min);
        EXPECT_EQ(sphere->range.latitude_max, range.latitude_max);
    } else {
        EXPECT_EQ(std::get<PerspectiveCamera>(a.camera).fov_x_rad, std::get<PerspectiveCamera>(b.camera).fov_x_rad);
    }
    EXPECT_EQ(a.camera_pose.position_m, b.camera_pose.position_m);
    EXPECT_EQ(a.camera_pose.orientation, b.camera_pose.orientation);
    EXPECT_EQ(a.head.position_m, b.head.position_m);
    EXPECT_EQ(a.head.orientation, b.head.orientation);
    EXPECT_EQ(a.eye, b.eye);
    EXPECT_EQ(a.ipd_m, b.ipd_m);
    EXPECT_EQ(a.lock, b.lock);
    EXPECT_EQ(a.lean_m, b.lean_m);
    EXPECT_EQ(a.exposure, b.exposure);
    EXPECT_EQ(a.seed, b.seed);
    EXPECT_EQ(a.samples_per_pixel, b.samples_per_pixel);
    EXPECT_EQ(a.scene, b.scene);
    EXPECT_EQ(a.host, b.host);
    EXPECT_EQ(a.geometry_fingerprint, b.geometry_fingerprint);
}

}  // namespace equistream
