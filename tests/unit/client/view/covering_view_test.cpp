#include <client/pipeline/covering_view.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace equistream::test {
namespace {

constexpr ViewSize plenty{8192, 8192};

double tangent_at(const CoveringView& view, double column) {
    return (column - 0.5 * view.camera.width) / view.camera.focal_px();
}

void expect_covers(const std::array<FieldOfView, 2>& eyes, const CoveringView& view) {
    const double focal = view.camera.focal_px();
    for (std::size_t i = 0; i < 2; ++i) {
        const ViewPart& part = view.parts[i];
        EXPECT_GE(part.left, 0);
        EXPECT_GE(part.top, 0);
        EXPECT_LE(part.left + part.width, view.camera.width);
        EXPECT_LE(part.top + part.height, view.camera.height);
        // Its angles are those of its edges, and it has what the eye is to see, and less than a pixel more.
        EXPECT_NEAR(std::tan(part.fov.left_rad), tangent_at(view, part.left), 1e-12);
        EXPECT_NEAR(std::tan(part.fov.right_rad), tangent_at(view, part.left + part.width), 1e-12);
        EXPECT_NEAR(std::tan(part.fov.up_rad) * focal, 0.5 * view.camera.height - part.top, 1e-9);
        EXPECT_NEAR(std::tan(part.fov.down_rad) * focal, 0.5 * view.camera.height - part.top - part.height, 1e-9);
        for (const auto& [found, wanted] : {std::pair{-part.fov.left_rad, -eyes[i].left_rad},
                                            {part.fov.right_rad, eyes[i].right_rad},
                                            {part.fov.up_rad, eyes[i].up_rad},
                                            {-part.fov.down_rad, -eyes[i].down_rad}}) {
            const double more_px = focal * (std::tan(found) - std::tan(wanted));
            EXPECT_GE(more_px, -1.1e-3);
            EXPECT_LT(more_px, 1);
        }
    }
}

TEST(CoveringView, CoversBothEyesWithWholePixels) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> angle(0.2, 1.1);
    for (int k = 0; k < 200; ++k) {
        std::array<FieldOfView, 2> eyes;
        for (FieldOfView& eye : eyes)
            eye = {-angle(random), angle(random), angle(random), -angle(random)};
        const CoveringView view = covering_view(eyes, 700, plenty);
        expect_covers(eyes, view);
        EXPECT_NEAR(view.camera.focal_px() * (std::tan(eyes[0].right_rad) - std::tan(eyes[0].left_rad)), 700, 1e-6);
    }
}

TEST(CoveringView, KeepsWithinWhatARuntimeTakes) {
    const std::array<FieldOfView, 2> eyes = {FieldOfView{-1.1, 0.9, 0.8, -1.0}, FieldOfView{-0.9, 1.1, 0.8, -1.0}};
    const CoveringView view = covering_view(eyes, 5000, {1000, 700});
    EXPECT_LE(view.camera.width, 1000);
    EXPECT_LE(view.camera.height, 700);
    expect_covers(eyes, view);
    EXPECT_GT(view.camera.height, 690) << "and not much less";
}

TEST(CoveringView, HasPixelsWhateverTheAngles) {
    for (const double odd : {0.0, 3.0, -3.0}) {
        const FieldOfView eye{-odd, odd, odd, -odd};
        for (const ViewPart& part : covering_view({eye, eye}, 500, plenty).parts) {
            EXPECT_GE(part.width, 1);
            EXPECT_GE(part.height, 1);
        }
    }
}

/// Edges that lie within pixels cost a pixel at most.
TEST(FittedView, FillsTheRoomAndHoldsNoMore) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> angle(0.2, 1.1);
    std::uniform_int_distribution<int> side(1, 400);
    for (int k = 0; k < 1000; ++k) {
        std::array<FieldOfView, 2> eyes;
        for (FieldOfView& eye : eyes)
            eye = {-angle(random), angle(random), angle(random), -angle(random)};
        const ViewSize room{side(random), side(random)};
        SCOPED_TRACE(testing::Message() << k << ": " << room.width << "x" << room.height);
        const CoveringView view = fitted_view(eyes, room, plenty);
        expect_covers(eyes, view);
        const auto [left, right] = view.parts;
        const int width = std::max(left.width, right.width), height = std::max(left.height, right.height);
        EXPECT_LE(width, room.width);
        EXPECT_LE(height, room.height);
        EXPECT_TRUE(width >= room.width - 1 || height >= room.height - 1) << width << "x" << height;
    }
}

TEST(FittedView, HasAllPixelsOfSymmetricEyes) {
    for (const auto& [width, height] : {std::pair{640, 480}, {641, 481}, {640, 481}, {641, 480}, {2, 1}, {1, 1}}) {
        SCOPED_TRACE(testing::Message() << width << "x" << height);
        const double up_rad = std::atan(std::tan(0.8) * height / width);
        const FieldOfView eye{-0.8, 0.8, up_rad, -up_rad};
        const CoveringView view = fitted_view({eye, eye}, {width, height}, plenty);
        EXPECT_NEAR(view.camera.fov_x_rad, 1.6, 1e-12);
        for (const ViewPart& part : view.parts) {
            EXPECT_EQ(part.left, 0);
            EXPECT_EQ(part.top, 0);
            EXPECT_EQ(part.width, width);
            EXPECT_EQ(part.height, height);
        }
    }
}

/// As many columns as the narrow eye could have would be thousands of the wide one's.
TEST(FittedView, HoldsEyesThatAreMostUnequal) {
    const FieldOfView narrow{-0.0005, 0.0005, 0.0005, -0.0005}, wide{-1.48, 1.48, 1.48, -1.48};
    for (const std::array<FieldOfView, 2>& eyes : {std::array{narrow, wide}, {wide, narrow}}) {
        const CoveringView view = fitted_view(eyes, {100, 100}, max_covering_view);
        for (const ViewPart& part : view.parts) {
            EXPECT_LE(part.width, 100);
            EXPECT_LE(part.height, 100);
        }
        EXPECT_EQ(std::max(view.parts[0].width, view.parts[1].width), 100);
    }
}

}  // namespace
}  // namespace equistream::test
