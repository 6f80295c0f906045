#include <client/pipeline/covering_view.h>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace equistream::test
