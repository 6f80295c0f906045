/// The GPU's reliability map against the CPU's.
#include "filled_pictures.h"
#include "gl_fixture.h"

#include <client/confidence/gl/reliability_map.h>
#include <tests/unit/client/reliability_scene.h>

#include <array>
#include <random>

namespace equistream::test {
namespace {

/// So that no difference between neighbours is like another.
void add_noise(EyePicture& picture, unsigned seed) {
    std::mt19937 random(seed);
    for (std::uint8_t& sample : picture.rgba.samples())
        sample = std::uint8_t(std::clamp<int>(sample + int(random() % 41) - 20, 0, 255));
}

class GlReliability : public Gl {
protected:
    /// Two eyes' maps at once.
    void expect_the_cpus(const SourceView& source, std::span<const EyeView, 2> eyes,
                         std::span<const EyePicture, 2> pictures, const ReliabilityOptions& options = {},
                         const SourceView* right = nullptr) {
        targets.size_for(eyes[0].camera, 2);
        const auto depth_of = [&](std::size_t k) {
            return eyes[k].depth_m.data != nullptr ? eyes[k].depth_m : pictures[k].depth_m.view();
        };
        const bool has_depth = depth_of(0).data != nullptr;
        for (std::size_t k = 0; k < 2; ++k) {
            upload(pictures[k], int(k), targets);
            if (has_depth)
                targets.upload_depth(int(k), eyes[0].camera, depth_of(k));
        }
        gl::SourceTextures textures;
        textures.describe(source.camera);
        gl::SpecularTextures specular;
        specular.upload(source);
        const gl::EyeDepth depth = has_depth ? targets.depth() : gl::EyeDepth{};
        map.estimate({source, textures, specular}, {eyes, depth, targets, {nullptr, right}}, options);
        for (std::size_t k = 0; k < 2; ++k) {
            EyePicture expected = pictures[k], found;
            estimate_reliability(k == 1 && right != nullptr ? *right : source, eyes[k], expected, options);
            map.download(int(k), found);
            std::int64_t others = 0;
            int worst = 0;
            for (std::size_t i = 0; i < expected.reliability.samples().size(); ++i) {
                const int off = std::abs(expected.reliability.samples()[i] - found.reliability.samples()[i]);
                others += off > 1;
                worst = std::max(worst, off);
            }
            // Where a sum lies at the very end of a table's entry, either entry will do.
            EXPECT_LE(others, 3) << "eye " << k << ", worst " << worst;
        }
    }

    gl::TargetsWithDepth targets;
    gl::ReliabilityMap map;
};

const Pose further{{-0.1, 0.05, 0.03}, yaw_pitch(0.1, -0.05)};

TEST_F(GlReliability, IsTheCpusWhateverMadeThePicture) {
    for (const char* fill : {"none", "pushpull", "spread"})
        for (const char* method : {"surface", "sphere", "splat"}) {
            SCOPED_TRACE(std::string(method) + " " + fill);
            std::array played = {Played(ball_and_wall, smooth_colour, moved, method, fill),
                                 Played(ball_and_wall, smooth_colour, further, method, fill)};
            const std::array eyes = {played[0].eye, played[1].eye};
            std::array pictures = {played[0].picture, played[1].picture};
            add_noise(pictures[0], 7);
            add_noise(pictures[1], 8);
            expect_the_cpus(played[0].view(), eyes, pictures, {.depth_tolerance_w = 0.01});
            expect_the_cpus(played[0].view(), eyes, pictures,
                            {.visible_loss = VisibleLoss{{1, 5, 9, 30, 4, 4, 60, 255}}});
        }
}

/// One eye that has not moved, one that looks elsewhere.
TEST_F(GlReliability, OfEyesAtTheSource) {
    std::array played = {Played(ball_and_wall, smooth_colour, Pose{}, "surface", "none"),
                         Played(ball_and_wall, smooth_colour, Pose{{0, 0, 0}, yaw_pitch(2, 1)}, "surface", "none")};
    const std::array eyes = {played[0].eye, played[1].eye};
    add_noise(played[0].picture, 1);
    add_noise(played[1].picture, 2);
    const std::array pictures = {played[0].picture, played[1].picture};
    expect_the_cpus(played[0].view(), eyes, pictures);
    // And the source's very view.
    SourceView same = played[0].view();
    same.camera = eye_camera;
    expect_the_cpus(same, eyes, pictures);
    VisibleLoss loss;
    loss.share_255.fill(51);
    expect_the_cpus(same, eyes, pictures, {.visible_loss = loss});
}

/// Of a frame with a sphere for each eye: the right eye stands where its own sphere does.
TEST_F(GlReliability, JudgesEachEyeByItsOwnSource) {
    std::array played = {Played(ball_and_wall, smooth_colour, Pose{}, "surface", "none"),
                         Played(ball_and_wall, smooth_colour, moved, "surface", "none")};
    const std::array eyes = {played[0].eye, played[1].eye};
    add_noise(played[0].picture, 1);
    add_noise(played[1].picture, 2);
    const std::array pictures = {played[0].picture, played[1].picture};
    SourceView right = played[0].view();
    right.pose = moved;
    expect_the_cpus(played[0].view(), eyes, pictures, {}, &right);
    EyePicture there = pictures[1], elsewhere = pictures[1];
    estimate_reliability(right, eyes[1], there);
    estimate_reliability(played[0].view(), eyes[1], elsewhere);
    EXPECT_FALSE(std::ranges::equal(there.reliability.samples(), elsewhere.reliability.samples()));
}

TEST_F(GlReliability, FindsMirrors) {
    std::array played = {Played(ball_and_wall, smooth_colour, moved, "surface", "pushpull"),
                         Played(ball_and_wall, smooth_colour, further, "surface", "pushpull")};
    FloatImage specular(640, 320, 1);
    for (int y = 0; y < 320; ++y)
        for (int x = 0; x < 640; ++x)
            specular.pixel(x, y)[0] = (x / 7 + y / 5) % 2 == 0 ? 1.0f : 0.0f;
    SourceView source = played[0].view();
    source.specular = specular.view();
    const std::array eyes = {played[0].eye, played[1].eye};
    std::array pictures = {played[0].picture, played[1].picture};
    for (EyePicture& picture : pictures)
        add_noise(picture, 7);
    expect_the_cpus(source, eyes, pictures);
    expect_the_cpus(source, eyes, pictures, {.specular_reworked = true});
}

/// Every kind of origin side by side; sources whose pixels are small and large.
TEST_F(GlReliability, TakesAnyOriginAndSize) {
    for (const int source_width : {64, 2000}) {
        const ByteImage rgb(source_width, source_width / 2, 3);
        const SourceView source{
            .rgb = rgb.view(), .camera = EquirectCamera{source_width, source_width / 2, {}}, .box_radius_m = 0.063};
        for (const auto& [width, height] : {std::pair{34, 7}, {61, 41}, {97, 70}, {20, 9}, {300, 40}}) {
            SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
            const PerspectiveCamera camera{width, height, 1.2};
            std::array<EyePicture, 2> pictures;
            std::array<FloatImage, 2> depths;
            std::array<EyeView, 2> eyes;
            std::mt19937 random(static_cast<unsigned>(width));
            for (std::size_t k = 0; k < 2; ++k) {
                pictures[k].reset(camera);
                depths[k] = FloatImage(width, height, 1);
                for (int y = 0; y < height; ++y)
                    for (int x = 0; x < width; ++x) {
                        for (int c = 0; c < 4; ++c)
                            pictures[k].rgba.pixel(x, y)[c] = std::uint8_t(random() % 256);
                        const bool any = k == 0 ? random() % 3 == 0 : random() % 200 != 0;
                        pictures[k].origin.pixel(x, y)[0] =
                            std::uint8_t(any ? random() % unsigned(pixel_origin_count) : 1);
                        depths[k].pixel(x, y)[0] =
                            random() % 9 == 0 ? float(infinity) : 1 + float(random() % 1000) / 500;
                    }
                eyes[k] = {camera, k == 0 ? moved : further, depths[k].view()};
            }
            expect_the_cpus(source, eyes, pictures);
        }
    }
}

}  // namespace
}  // namespace equistream::test
