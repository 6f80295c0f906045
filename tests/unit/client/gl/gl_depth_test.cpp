#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/scenes/generate/scratch_folder.h>

#include <client/depth/gl/gl_depth.h>
#include <client/depth/ray_depth.h>
#include <client/gpu/context.h>
#include <scenes/generate/generate.h>

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace equistream::test {
namespace {

const EquirectCamera sphere{512, 256, {}};
const PerspectiveCamera eye{192, 108, pi / 2};

struct Agreement {
    int known = 0, off = 0;
};

/// Whether the depth around runs nearly straight: no outline is here, and nothing that is smaller than a sample, of
/// which texels beside the sample's own direction may show another.
bool is_smooth(const FloatImage& depth_m, int x, int y) {
    const auto at = [&](int column, int row) {
        return depth_m.pixel((column + depth_m.width()) % depth_m.width(), std::clamp(row, 0, depth_m.height() - 1))[0];
    };
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
            const float middle = at(x + i, y + j);
            for (const float bend : {at(x + i - 1, y + j) - 2 * middle + at(x + i + 1, y + j),
                                     at(x + i, y + j - 1) - 2 * middle + at(x + i, y + j + 1)})
                if (!(std::abs(bend) <= 2e-3f * middle))
                    return false;
        }
    return true;
}

/// Of the samples that both know.
Agreement agreement(const FloatImage& expected, const FloatImage& found) {
    Agreement agreement;
    for (int y = 0; y < expected.height(); ++y)
        for (int x = 0; x < expected.width(); ++x) {
            const float a = expected.pixel(x, y)[0], b = found.pixel(x, y)[0];
            if (std::isnan(b) || !is_smooth(expected, x, y))
                continue;
            ++agreement.known;
            agreement.off += !(a == b || std::abs(a - b) <= 1e-3f * a);
        }
    return agreement;
}

int count_known(const FloatImage& depth_m) {
    return int(std::ranges::count_if(depth_m.samples(), [](float r) { return !std::isnan(r); }));
}

FloatImage cast(DepthSource& depth, const Camera& camera, const Pose& pose) {
    FloatImage depth_m(width_of(camera), height_of(camera), 1);
    depth.cast(camera, pose, depth_m.view());
    return depth_m;
}

/// The generated scene has leaves cut by masks, things that move, mirrors and thin rails.
class GlDepthOfPavilion : public testing::Test {
protected:
    static void SetUpTestSuite() {
        gl::abort_on_errors();
        folder = std::make_unique<ScratchFolder>("gl-depth");
        scene = load_scene(write_scene(make_scene(find_generator("pavilion")), folder->path()));
    }
    static void TearDownTestSuite() { folder.reset(); }

    static inline std::unique_ptr<ScratchFolder> folder;
    static inline SceneDescription scene;
};

TEST_F(GlDepthOfPavilion, IsThatOfRays) {
    RayDepth ray(scene);
    GlDepth drawn(scene), cube(scene, {.cube = true});
    EXPECT_FALSE(drawn.driver().empty());
    for (const double time_s : {0.0, 2.5}) {
        for (DepthSource* source :
             {static_cast<DepthSource*>(&ray), static_cast<DepthSource*>(&drawn), static_cast<DepthSource*>(&cube)})
            source->set_time(time_s);
        const Pose head = scene.camera_path.at(time_s);
        const Pose at{head.position_m + head.orientation * glm::dvec3(0.0315, 0, 0), head.orientation};
        const auto expect_rays = [&](const FloatImage& expected, const FloatImage& found) {
            const Agreement smooth = agreement(expected, found);
            EXPECT_GT(smooth.known, 0.15 * count_known(found)) << time_s;
            EXPECT_LT(smooth.off, 0.005 * smooth.known) << time_s;
        };
        const FloatImage flat_m = cast(drawn, eye, at);
        EXPECT_EQ(count_known(flat_m), eye.width * eye.height);
        expect_rays(cast(ray, eye, at), flat_m);
        const FloatImage expected_m = cast(ray, sphere, head), cube_m = cast(cube, sphere, head);
        EXPECT_EQ(count_known(cube_m), sphere.width * sphere.height);
        EXPECT_EQ(cube.figures().views, 6);
        expect_rays(expected_m, cube_m);
        const FloatImage part_m = cast(drawn, sphere, head);
        EXPECT_EQ(drawn.figures().views, 1);
        expect_rays(expected_m, part_m);
        // Of a whole sphere what an eye of 90 by 59 degrees sees, some 14 % in its middle, and what parallax adds.
        EXPECT_GT(count_known(part_m), 0.08 * sphere.width * sphere.height);
        EXPECT_LT(count_known(part_m), 0.3 * sphere.width * sphere.height);
        EXPECT_LT(drawn.figures().triangles, cube.figures().triangles);
    }
}

/// Where no eye has asked, all of a sphere is wanted.
TEST_F(GlDepthOfPavilion, WithoutEyesTheWholeSphereIsDrawn) {
    GlDepth drawn(scene);
    const FloatImage depth_m = cast(drawn, sphere, scene.camera_path.at(0));
    EXPECT_EQ(count_known(depth_m), sphere.width * sphere.height);
    EXPECT_EQ(drawn.figures().views, 6);
    drawn.set_time(1);
    cast(drawn, eye, scene.camera_path.at(1));
    EXPECT_LT(count_known(cast(drawn, sphere, scene.camera_path.at(1))), sphere.width * sphere.height / 2);
}

/// More views than are told apart: a sphere is drawn whole rather than without one of them.
TEST_F(GlDepthOfPavilion, ManyViewsGetTheWholeSphere) {
    GlDepth drawn(scene);
    const Pose head = scene.camera_path.at(0);
    for (int i = 0; i < 5; ++i)
        cast(drawn, eye, {head.position_m, head.orientation * yaw_pitch(0.01 * i, 0)});
    EXPECT_EQ(count_known(cast(drawn, sphere, head)), sphere.width * sphere.height);
}

/// Whoever else draws in this thread goes on with his own context.
TEST_F(GlDepthOfPavilion, LeavesTheCurrentContextAsItWas) {
    const auto other = gl::make_offscreen_context();
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    const auto expect_other = [texture] { EXPECT_EQ(glIsTexture(texture), GL_TRUE); };
    {
        GlDepth drawn(scene);
        expect_other();
        cast(drawn, eye, scene.camera_path.at(0));
        expect_other();
        EXPECT_FALSE(drawn.driver().empty());
        expect_other();
    }
    expect_other();
    glDeleteTextures(1, &texture);
}

}  // namespace
}  // namespace equistream::test
