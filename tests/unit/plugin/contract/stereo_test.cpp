#include <equistream/image_motion.h>

#include <gtest/gtest.h>

namespace equistream {
namespace {

double length(const Vector3<double>& v) {
    return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

TEST(OmnidirectionalStereo, eyes_are_an_ipd_apart_at_the_equator_and_together_at_the_poles) {
    const PoleMerge merge;
    for (const double longitude : {-3.0, -1.0, 0.0, 0.5, 2.0}) {
        for (const double latitude : {-1.0, -0.5, 0.0, 0.7, 1.04}) {
            const auto left = ods_eye_offset(longitude, latitude, -0.0315, merge);
            const auto right = ods_eye_offset(longitude, latitude, 0.0315, merge);
            EXPECT_NEAR(length({right.x - left.x, right.y - left.y, right.z - left.z}), 0.063, 1e-15);
            EXPECT_EQ(left.y, 0);
        }
        for (const double latitude : {-pi / 2, -1.4, 1.31, 1.5, pi / 2})
            EXPECT_NEAR(length(ods_eye_offset(longitude, latitude, 0.0315, merge)), 0, 1e-17);
    }
    const auto ahead = ods_eye_offset(0.0, 0.0, 0.0315, merge);
    EXPECT_GT(ahead.x, 0) << "the right eye is to the right of one who looks forward";
}

TEST(OmnidirectionalStereo, each_eye_looks_tangentially) {
    for (double longitude = -3; longitude < 3; longitude += 0.37) {
        const auto eye = ods_eye_offset(longitude, 0.4, 0.03, PoleMerge{});
        const auto d = direction_from_longitude_latitude(longitude, 0.4);
        EXPECT_NEAR(eye.x * d.x + eye.z * d.z, 0, 1e-17);
    }
}

TEST(OmnidirectionalStereo, the_fade_is_smooth) {
    const PoleMerge merge;
    const double step = 1e-5;
    double steepest = 0;
    for (double latitude = -pi / 2; latitude < pi / 2; latitude += 0.001) {
        const double before = pole_fade(latitude - step, merge), here = pole_fade(latitude, merge),
                     after = pole_fade(latitude + step, merge);
        EXPECT_GE(here, 0);
        EXPECT_LE(here, 1);
        steepest = std::max(steepest, std::abs(after - here) / step);
        // The slope has no jump: second differences stay at the curvature of a cosine.
        EXPECT_LT(std::abs(after - 2 * here + before) / (step * step),
                  1.01 * pi * pi / 2 / std::pow(pi / 12, 2) + 1e-3);
    }
    EXPECT_NEAR(steepest, pi / 2 / (pi / 12), 0.01);
}

TEST(OmnidirectionalStereo, without_merging_the_circle_stays) {
    EXPECT_EQ(pole_fade(1.5707, PoleMerge{pi, pi}), 1);
}

TEST(OmnidirectionalStereo, a_point_is_found_in_the_direction_in_which_its_eye_sees_it) {
    for (const PoleMerge merge : {PoleMerge{}, PoleMerge{pi, pi}, PoleMerge{0.2, 1.5}})
        for (double longitude = -3.1; longitude < 3.1; longitude += 0.41)
            for (double latitude = -1.5; latitude < 1.51; latitude += 0.1)
                for (const double distance : {0.3, 1.0, 30.0})
                    for (const double side : {-0.0315, 0.0315, 0.2}) {
                        if (3 * std::abs(side) > distance)
                            continue;
                        const auto eye = ods_eye_offset(longitude, latitude, side, merge);
                        const auto d = direction_from_longitude_latitude(longitude, latitude);
                        const auto seen = ods_direction<double>(
                            {eye.x + distance * d.x, distance * d.y, eye.z + distance * d.z}, side, merge);
                        EXPECT_NEAR(length({seen.x - d.x, seen.y - d.y, seen.z - d.z}), 0, 2e-5)
                            << longitude << " " << latitude << " " << distance << " " << side;
                    }
}

TEST(OmnidirectionalStereo, what_lies_inside_the_circle_has_a_direction_too) {
    const auto d = ods_direction<double>({0.001, 0.0, -0.001}, 0.0315, PoleMerge{});
    EXPECT_NEAR(length(d), 1, 1e-12);
}

}  // namespace
}  // namespace equistream
