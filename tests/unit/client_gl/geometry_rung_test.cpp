/// The `geometry` rung on the GPU is what the CPU makes of the same surfaces.
#include "analytic_scene.h"
#include "filled_pictures.h"
#include "gl_fixture.h"
#include "scratch_folder.h"

#include <fill/gl/geometry_rung.h>

#include <equistream/picture.h>
#include <equistream/srgb.h>
#include <equistream_client/ray_colour.h>
#include <equistream_scene/scene.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <random>
#include <vector>

namespace equistream::test {
namespace {

constexpr PerspectiveCamera camera{240, 160, pi / 2};

/// Before a wall whose texture repeats, in fine texels and seen aslant: a leaf with holes, a lamp, a plain block.
class GlGeometryRung : public Gl {
protected:
    GlGeometryRung() {
        scene.file = scene.model = folder / "leaf.obj";
        ByteImage checks(40, 24, 3), leaf(16, 16, 4);
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 40; ++x) {
                const bool odd = ((x / 5 + y / 4) & 1) != 0;
                const std::array<std::uint8_t, 3> colour = {std::uint8_t(odd ? 220 : 60), std::uint8_t(40 + 5 * x),
                                                            std::uint8_t(90 + 6 * y)};
                std::copy_n(colour.data(), 3, checks.pixel(x, y));
            }
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 16; ++x) {
                const bool hole = (x / 4 + y / 4) % 3 == 0;
                const std::array<std::uint8_t, 4> colour = {80, 180, std::uint8_t(8 * x), std::uint8_t(hole ? 0 : 255)};
                std::copy_n(colour.data(), 4, leaf.pixel(x, y));
            }
        write_picture(folder / "checks.png", checks.view());
        write_picture(folder / "leaf.png", leaf.view());
        std::ofstream(folder / "leaf.mtl") << "newmtl wall\nKd 1 1 1\nmap_Kd checks.png\n"
                                              "newmtl leaf\nKd 1 1 1\nmap_Kd leaf.png\n"
                                              "newmtl lamp\nKd 1 1 1\nKe 5 5 5\nnewmtl block\nKd 0.5 0.2 0.1\n";
        std::ofstream(scene.model)
            << "mtllib leaf.mtl\nvt 0 0\nvt 6.5 0\nvt 6.5 4.5\nvt 0 4.5\nvt 1 0\nvt 1 1\nvt 0 1\n"
               "o wall\nusemtl wall\nv -4 -3 -4\nv 4 -3 -2.5\nv 4 3 -2.5\nv -4 3 -4\nf -4/1 -3/2 -2/3 -1/4\n"
               "o leaf\nusemtl leaf\nv -0.9 -0.5 -1.5\nv 0.1 -0.5 -1.5\nv 0.1 0.5 -1.5\nv -0.9 0.5 -1.5\n"
               "f -4/1 -3/5 -2/6 -1/7\n"
               "o lamp\nusemtl lamp\nv 0.3 0.3 -1.5\nv 0.9 0.3 -1.5\nv 0.9 0.9 -1.5\nv 0.3 0.9 -1.5\nf -4 -3 -2 -1\n"
               "o block\nusemtl block\nv 0.3 -0.8 -1.4\nv 0.7 -0.8 -1.2\nv 0.7 0 -1.2\nv 0.3 0 -1.4\nf -4 -3 -2 -1\n"
               "v 0.7 -0.8 -1.2\nv 1.2 -0.8 -1.6\nv 1.2 0 -1.6\nv 0.7 0 -1.2\nf -4 -3 -2 -1\n";
    }

    /// Of every pixel.
    static std::vector<GeometryHit> cast(RayColour& colours, const EyeView& eye) {
        std::vector<GeometryRay> rays;
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x)
                rays.push_back({glm::vec3(eye.pose.position_m),
                                glm::vec3(eye.pose.orientation * camera.direction(x + 0.5, y + 0.5)),
                                float(camera.pixel_angle_rad())});
        std::vector<GeometryHit> hits(rays.size());
        colours.cast(rays, hits);
        return hits;
    }

    /// What is lit from one side, with gaps of all sizes.
    static EyePicture lit_with_gaps(const std::vector<GeometryHit>& hits, std::mt19937& random) {
        EyePicture picture;
        picture.reset(camera);
        for (std::size_t p = 0; p < hits.size(); ++p) {
            const float light = 0.4f + 0.5f * float(p % std::size_t(camera.width)) / float(camera.width);
            for (int c = 0; c < 3; ++c)
                picture.rgba.samples()[4 * p + std::size_t(c)] =
                    std::uint8_t(255 * linear_to_srgb(std::min(hits[p].base_colour[c] * light, 1.0f)));
            picture.rgba.samples()[4 * p + 3] = 255;
            picture.origin.samples()[p] = std::uint8_t(PixelOrigin::source);
        }
        const auto number = [&](int end) { return std::uniform_int_distribution<int>(0, end - 1)(random); };
        for (int box = 0; box < 12; ++box) {
            const int left = number(camera.width), top = number(camera.height), wide = 2 << number(5),
                      high = 2 << number(6);
            for (int y = top; y < std::min(top + high, camera.height); ++y)
                for (int x = left; x < std::min(left + wide, camera.width); ++x) {
                    std::fill_n(picture.rgba.pixel(x, y), 4, std::uint8_t{0});
                    *picture.origin.pixel(x, y) = std::uint8_t(PixelOrigin::gap);
                }
        }
        return picture;
    }

    /// Whether rays see one surface in all pixels around, so that none lies on a raster's outline.
    static bool is_inside(const std::vector<GeometryHit>& hits, int x, int y) {
        const auto at = [&](int i, int j) { return hits[std::size_t(j) * std::size_t(camera.width) + std::size_t(i)]; };
        const GeometryHit own = at(x, y);
        for (int j = std::max(y - 1, 0); j <= std::min(y + 1, camera.height - 1); ++j)
            for (int i = std::max(x - 1, 0); i <= std::min(x + 1, camera.width - 1); ++i)
                if (at(i, j).instance != own.instance ||
                    std::isfinite(at(i, j).distance_m) != std::isfinite(own.distance_m))
                    return false;
        return true;
    }

    const ScratchFolder folder{"geometry-rung"};
    SceneDescription scene;
};

TEST_F(GlGeometryRung, LightsSurfacesAsTheCpuDoes) {
    const SceneModel model = load_model(scene);
    gl::DepthPass pass(model);
    gl::GeometryRung rung(model);
    gl::EyeTargets targets;
    gl::GapTiles gaps;
    RayColour colours(scene);
    std::mt19937 random(4);
    targets.size_for(camera, 2);
    int stay = 0;
    for (const double aside_m : {0.0, 0.3}) {
        const std::array<EyeView, 2> eyes = {EyeView{camera, {{aside_m - 0.03, 0, 0}, {1, 0, 0, 0}}},
                                             EyeView{camera, {{aside_m + 0.03, 0.1, 0.2}, yaw_pitch(0.2, -0.1)}}};
        std::array<std::vector<GeometryHit>, 2> hits;
        std::array<EyePicture, 2> open;
        std::vector<gl::DepthViewpoint> views;
        for (std::size_t k = 0; k < 2; ++k) {
            hits[k] = cast(colours, eyes[k]);
            open[k] = lit_with_gaps(hits[k], random);
            upload(open[k], int(k), targets);
            views.push_back({camera, eyes[k].pose});
        }
        pass.draw(views);
        gaps.find(targets);
        rung.fill(pass, {eyes, gl::EyeDepth{pass.texture(), gl::DepthPass::inverse_scale()}, gaps, targets});
        for (std::size_t k = 0; k < 2; ++k) {
            SCOPED_TRACE(k);
            const EyePicture expected = filled("geometry", {.geometry = &colours}, eyes[k], open[k]);
            EyePicture found;
            targets.download(int(k), found);
            double squares = 0;
            int inside = 0, other_origins = 0;
            for (int y = 0; y < camera.height; ++y)
                for (int x = 0; x < camera.width; ++x) {
                    const int origin = *expected.origin.pixel(x, y);
                    const std::uint8_t *e = expected.rgba.pixel(x, y), *f = found.rgba.pixel(x, y);
                    if (*open[k].origin.pixel(x, y) != std::uint8_t(PixelOrigin::gap)) {
                        EXPECT_TRUE(std::equal(e, e + 4, f));
                        continue;
                    }
                    if (!is_inside(hits[k], x, y))
                        continue;
                    other_origins += origin != *found.origin.pixel(x, y);
                    stay += origin == std::uint8_t(PixelOrigin::gap);
                    inside += origin != std::uint8_t(PixelOrigin::gap);
                    for (int c = 0; c < 3; ++c)
                        squares += std::pow(double(e[c]) - double(f[c]), 2);
                }
            EXPECT_GT(inside, 1000);
            EXPECT_EQ(other_origins, 0);
            EXPECT_GE(10 * std::log10(255.0 * 255 * 3 * inside / std::max(squares, 1e-9)), 50) << inside;
            EXPECT_LT(std::abs(found.count(PixelOrigin::geometry) - expected.count(PixelOrigin::geometry)), inside / 50)
                << "outlines included";
        }
    }
    EXPECT_GT(stay, 50) << "the lamp, and what nothing like it is seen of";
}

}  // namespace
}  // namespace equistream::test
