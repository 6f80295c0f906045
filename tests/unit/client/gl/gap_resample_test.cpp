#include "filled_pictures.h"
#include "gl_fixture.h"

#include <client/fill/gl/fill_pass.h>
#include <client/fill/gl/gap_resample.h>
#include <client/fill/gl/push_pull.h>
#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/client/engine_scenes.h>
#include <tests/unit/client/fill_scene.h>

#include <array>

namespace equistream::test {
namespace {

/// Two eyes' views of a scene, with the gaps that a main picture leaves.
struct OpenViews {
    PerspectiveCamera camera{320, 200, pi / 2};
    std::array<FloatImage, 2> depths;
    std::array<EyeView, 2> eyes;
    std::array<EyePicture, 2> before;

    OpenViews(const Distance& distance, const SourceView& main, const std::array<Pose, 2>& poses) {
        const auto engine = make_engine("surface");
        engine->set_source(main);
        for (std::size_t k = 0; k < 2; ++k) {
            depths[k] = depth_from(distance, camera, poses[k]);
            eyes[k] = {camera, poses[k], depths[k].view()};
            engine->reproject(eyes[k], before[k]);
        }
    }
};

class GlPasses : public Gl {
protected:
    /// Uploads the views, lets `fill` fill them and compares with the CPU's fill pass.
    template <typename Fill>
    void expect_the_cpus(const std::string& fill_pass, const FillInputs& inputs, const OpenViews& views,
                         const Fill& fill) {
        SCOPED_TRACE(fill_pass);
        targets.size_for(views.camera, 2);
        for (int k = 0; k < 2; ++k) {
            upload(views.before[std::size_t(k)], k, targets);
            targets.upload_depth(k, views.camera, views.eyes[std::size_t(k)].depth_m);
        }
        gaps.find(targets);
        const gl::EyeDepth depth = targets.depth();
        fill(gl::GapTargets{views.eyes, depth, gaps, targets});
        std::int64_t count = 0;
        for (int k = 0; k < 2; ++k) {
            const EyePicture& open = views.before[std::size_t(k)];
            const EyePicture expected = filled(fill_pass, inputs, views.eyes[std::size_t(k)], open);
            EyePicture found;
            targets.download(k, found);
            const FilledPixels pixels = compare_filled(open, expected, found);
            count += pixels.count;
            EXPECT_GE(pixels.psnr_db, 50) << "eye " << k << ", " << pixels.count << " pixels";
            // A point on the edge of what a tolerance allows falls on either side.
            EXPECT_LE(pixels.other_origins, 3 + pixels.count / 500) << "eye " << k << ", " << pixels.count << " pixels";
            EXPECT_TRUE(pixels.others_untouched) << "eye " << k;
        }
        EXPECT_GT(count, 200);
    }
    void expect_from_picture(const std::string& fill_pass, const FillInputs& inputs, const OpenViews& views,
                             std::span<const SourceView> pictures, PixelOrigin mark) {
        expect_the_cpus(fill_pass, inputs, views, [&](const gl::GapTargets& to) {
            for (const SourceView& picture : pictures) {
                textures.upload(picture);
                resample.fill({picture, textures, mark}, to);
            }
        });
    }

    gl::TargetsWithDepth targets;
    gl::GapTiles gaps;
    gl::GapResample resample;
    gl::SourceTextures textures;
};

const std::array<Pose, 2> leaning = {Pose{{0.0315, 0, 0}, {1, 0, 0, 0}},
                                     Pose{{0.02, 0.03, 0.05}, yaw_pitch(0.1, -0.1)}};

TEST_F(GlPasses, FillBehindABallWhatTheCpuFills) {
    FillScene scene;
    const OpenViews views(ball_and_wall, scene.main_view, leaning);
    Rendered behind = render(wall_alone, red_and_smooth, scene.main_camera, scene.left);
    for (int y = 0; y < 250; ++y)
        for (int x = 0; x < 400; ++x)
            if (*scene.main.depth_m.pixel(x, y) >= *behind.depth_m.pixel(x, y))
                *behind.depth_m.pixel(x, y) = std::nanf("");
    const SourceView hidden = behind.source(0.063);
    const FillInputs inputs{.main = &scene.main_view, .hidden = &hidden};
    expect_from_picture("hidden", inputs, views, {&hidden, 1}, PixelOrigin::hidden);
}

TEST_F(GlPasses, TakeFromTheSmallViewWhatTheCpuTakes) {
    FillScene scene;
    const OpenViews views(ball_and_wall, scene.main_view, leaning);
    const Rendered rendered = render(ball_and_wall, red_and_smooth, PerspectiveCamera{80, 50, pi / 2}, scene.right);
    SourceView small = rendered.source(0.063);
    for (const bool with_depth : {true, false}) {
        small.depth_m = with_depth ? rendered.depth_m.view() : ImageView<const float>{};
        const FillInputs inputs{.main = &scene.main_view, .small = &small};
        expect_from_picture("small", inputs, views, {&small, 1}, PixelOrigin::small);
    }
}

/// Each eye of the sphere nearest to it, which has a tint that tells it from the other's; what is mixed, last.
TEST_F(GlPasses, TakeFromPatchesWhatTheCpuTakes) {
    FillScene scene;
    const OpenViews views(ball_and_wall, scene.main_view,
                          {scene.right, Pose{{-0.02, 0.03, 0.05}, yaw_pitch(0.1, -0.1)}});
    Patches made;
    made.render_from(scene.left);
    for (int y = 0; y < made.atlas.height(); ++y)
        for (int x = 0; x < made.atlas.width(); ++x)
            if (made.atlas.slot_at(x, y).offset_index == 1)
                made.rgb.pixel(x, y)[0] = std::uint8_t(255 - made.rgb.pixel(x, y)[0]);
    const PatchesView patches = made.view(scene.left);
    gl::PatchTextures patch_textures;
    patch_textures.upload(patches);
    gl::PatchResample patch_resample;
    expect_the_cpus("patches", {.main = &scene.main_view, .patches = &patches}, views,
                    [&](const gl::GapTargets& to) { patch_resample.fill(patches, patch_textures, to); });
}

/// Pictures of every kind, across seams and at poles, from nearby and from beyond the head box: of views that are all
/// gap, everything that the fill pass's eyes may look at.
TEST_F(GlPasses, LookEarlierPicturesUpAsTheCpuDoes) {
    const SurfaceScene scene = furnished();
    const std::vector<Pose> poses = engine_eyes();
    const Rendered main_picture = render(scene, smooth_colour, EquirectCamera{720, 360, {}}, Pose{});
    const SourceView main = main_picture.source(0.11);
    for (const Camera& camera : engine_sources(720)) {
        const std::array made = {render(scene, smooth_colour, camera, Pose{{0.1, 0.02, -0.05}, yaw_pitch(0.7, 0.1)}),
                                 render(scene, smooth_colour, camera, Pose{{-0.1, 0.1, 0.05}, yaw_pitch(0.2, -0.2)})};
        const std::array earlier = {made[0].source(0.2), made[1].source(0.2)};
        for (std::size_t i = 0; i + 1 < poses.size(); i += 2) {
            // Flat and partial pictures do not show what the other eyes look at.
            if (i > 0 && !columns_close(camera))
                continue;
            SCOPED_TRACE(i);
            OpenViews views(scene, main, {poses[i], poses[i + 1]});
            for (EyePicture& picture : views.before)
                picture.reset(views.camera);
            expect_from_picture("earlier", {.main = &main, .earlier = earlier}, views, earlier, PixelOrigin::earlier);
        }
    }
}

/// What a slope before it hides, and the other side of what is thin.
TEST_F(GlPasses, LeaveWhatOtherPicturesDoNotSeeAsTheCpuDoes) {
    const auto floor_and_ceiling = [](const glm::dvec3& o, const glm::dvec3& d) {
        return std::min(to_plane(o, d, {0, 1, 0}, -1.6), to_plane(o, d, {0, 1, 0}, 1.6));
    };
    const auto tilted_planes = [](const glm::dvec3& o, const glm::dvec3& d) {
        return std::min(to_plane(o, d, {0.3, 1, 0.2}, -2), to_plane(o, d, {-0.2, 1, 0.3}, 2));
    };
    const auto sheet_and_wall = [](const glm::dvec3& o, const glm::dvec3& d) {
        const double sheet = to_plane(o, d, {1, 0, 0}, 0), z = o.z + sheet * d.z;
        return std::min(z > -2 && z < -0.5 ? sheet : infinity, to_plane(o, d, {0, 0, 1}, -3));
    };
    const auto expect_alike = [&](const Distance& distance, const Rendered& picture, const std::array<Pose, 2>& poses) {
        const SourceView earlier = picture.source(0.11);
        OpenViews views(distance, earlier, poses);
        for (EyePicture& open : views.before)
            open.reset(views.camera);
        expect_from_picture("earlier", {.main = &earlier, .earlier = {&earlier, 1}}, views, {&earlier, 1},
                            PixelOrigin::earlier);
    };
    const glm::dquat turn = yaw_pitch(0.2, 0.5);
    const Rendered near = render(floor_and_ceiling, smooth_colour, EquirectCamera{180, 90, {}}, Pose{{0, 0, 0}, turn});
    for (const double pitch : {-0.4, 0.5})
        expect_alike(
            tilted_planes, near,
            {Pose{{0.5, 0.1, -0.3}, turn * yaw_pitch(0, pitch)}, Pose{{0.5, 0.1, -0.3}, turn * yaw_pitch(pi, pitch)}});
    const Rendered left =
        render(sheet_and_wall, smooth_colour, EquirectCamera{720, 360, {}}, Pose{{-0.3, 0, 0}, {1, 0, 0, 0}});
    expect_alike(sheet_and_wall, left,
                 {Pose{{0.3, 0, 0}, yaw_pitch(0.2, 0)}, Pose{{0.2, 0.05, 0}, yaw_pitch(0.1, 0.1)}});
}

TEST_F(GlPasses, FillGapsOfAnyShapeByDirectionAsTheCpuDoes) {
    std::mt19937 random(11);
    const Rendered rendered = render(wall_alone, red_and_smooth, PerspectiveCamera{80, 50, pi / 2}, Pose{});
    SourceView small = rendered.source(0.063);
    small.depth_m = {};
    for (const unsigned gaps_of_ten : {3u, 5u, 7u}) {
        OpenViews views(wall_alone, small, {Pose{}, Pose{}});
        for (EyePicture& picture : views.before)
            for (int y = 0; y < 200; ++y)
                for (int x = 0; x < 320; ++x) {
                    const bool open = random() % 10 < gaps_of_ten || (x / 9 + y / 7) % 5 == 0;
                    *picture.origin.pixel(x, y) = std::uint8_t(open ? PixelOrigin::gap : PixelOrigin::source);
                }
        expect_from_picture("small", {.main = &small, .small = &small}, views, {&small, 1}, PixelOrigin::small);
    }
}

/// Where the main picture's mask, or an earlier one's own, says that a mirror shows something else from there.
TEST_F(GlPasses, PassMirrorsOverAsTheCpuDoes) {
    const Pose beside{{0.1, 0.05, 0}, yaw_pitch(0.3, -0.1)};
    const MirrorView main(EquirectCamera{720, 360, {}}, {}), other(EquirectCamera{720, 360, {}}, beside);
    // The one so close to the other picture that far mirrors look the same from there.
    const std::array<Pose, 2> poses = {Pose{beside.position_m + glm::dvec3(0.004, 0.003, 0), yaw_pitch(0.05, -0.6)},
                                       Pose{{-0.05, 0.02, 0.08}, yaw_pitch(-0.1, -0.7)}};
    SourceView painted = main.source(), masked = other.source();
    painted.specular = painted.virtual_depth_m = {};
    OpenViews views(MirrorRoom::depth, painted, poses);
    for (EyePicture& picture : views.before)
        picture.reset(views.camera);
    SourceView teller = main.source(), unmasked = other.picture.source(0.15);
    for (const bool with_images : {true, false}) {
        if (!with_images)
            teller.virtual_depth_m = masked.virtual_depth_m = {};
        gl::SourceTextures teller_textures;
        teller_textures.upload(teller);
        textures.upload(unmasked);
        gl::SpecularTextures tellers_planes, own_planes;
        tellers_planes.upload(teller);
        own_planes.upload(masked);
        gl::GapMirrors mirrors;
        const auto fill_by = [&](const gl::SpecularSource& by) {
            return [&](const gl::GapTargets& to) {
                gl::GapTargets with = to;
                with.image_behind = mirrors.find(by, to);
                resample.fill({unmasked, textures, PixelOrigin::hidden}, with);
            };
        };
        const FillInputs by_main{.main = &teller, .hidden = &unmasked}, by_itself{.main = &teller, .hidden = &masked};
        expect_the_cpus("hidden", by_main, views, fill_by({teller, teller_textures, tellers_planes}));
        expect_the_cpus("hidden", by_itself, views, fill_by({masked, textures, own_planes}));
        EXPECT_EQ(mirrors.find({painted, teller_textures, gl::SpecularTextures()},
                               {views.eyes, gl::EyeDepth{}, gaps, targets}),
                  0U);
        for (std::size_t eye = 0; eye < 2; ++eye) {
            const auto count = [&](const FillInputs& inputs) {
                return filled("hidden", inputs, views.eyes[eye], views.before[eye]).count(PixelOrigin::hidden);
            };
            const std::int64_t all = count({.main = &painted, .hidden = &unmasked});
            EXPECT_LT(count(by_main), all - 2000) << "mirrors are in sight";
            EXPECT_LT(count(by_itself), all - 2000);
        }
    }
}

}  // namespace

namespace {

/// What gap pixels see where the eyes have no depth of their own, as 1 / planar depth.
class GlFoundDepth : public Gl {
protected:
    GlFoundDepth() {
        scene.forget_eye_depth();
        targets.size_for(scene.camera, 1);
        upload(scene.unfilled, 0, targets);
        targets.upload_depth(0, scene.camera, scene.unfilled.depth_m.view());
        gaps.find(targets);
    }
    FloatImage inverses() const {
        const gl::Size size = targets.size();
        FloatImage image(size.width, size.height, 1);
        gl::download(targets.depth().texture, 0, size, {GL_RED, GL_FLOAT, sizeof(float)}, image.pixel(0, 0),
                     std::size_t(size.width) * sizeof(float));
        return image;
    }
    bool is_gap(int x, int y) const { return *scene.unfilled.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap); }
    /// Of all pixels, or of those that are no gaps.
    int differing(const FloatImage& a, const FloatImage& b, bool in_gaps) const {
        int count = 0;
        for (int y = 0; y < scene.camera.height; ++y)
            for (int x = 0; x < scene.camera.width; ++x) {
                const float p = *a.pixel(x, y), q = *b.pixel(x, y);
                count += (in_gaps || !is_gap(x, y)) && !(p == q || (std::isnan(p) && std::isnan(q)));
            }
        return count;
    }

    FillScene scene;
    gl::TargetsWithDepth targets;
    gl::GapTiles gaps;
    gl::FoundDepth found;
};

/// In gaps alone; what was drawn from one picture is forgotten before another one is asked.
TEST_F(GlFoundDepth, OfPatchesIsTheirsUntilItIsForgotten) {
    Patches made;
    made.render_from(scene.left);
    const PatchesView patches = made.view(scene.left);
    gl::PatchTextures textures;
    textures.upload(patches);
    const gl::EyeDepth depth = targets.depth();
    const gl::GapTargets to{std::span(&scene.eye, 1), depth, gaps, targets};
    const FloatImage before = inverses();
    found.draw_forward(patches, textures, to);
    const FloatImage drawn = inverses();
    EXPECT_EQ(differing(drawn, before, false), 0);
    const EyeRays rays(scene.camera, {}, {});
    int open = 0, known = 0, off = 0;
    for (int y = 0; y < scene.camera.height; ++y)
        for (int x = 0; x < scene.camera.width; ++x) {
            if (!is_gap(x, y))
                continue;
            ++open;
            const float inverse = *drawn.pixel(x, y);
            known += !std::isnan(inverse);
            off += std::abs(inverse * *scene.truth.depth_m.pixel(x, y) / rays.length(x, y) - 1) > 0.03f;
        }
    EXPECT_GT(open, 300);
    EXPECT_GT(known, 0.9 * open);
    EXPECT_LT(off, 0.2 * open) << "the ball's rim";

    found.forget(to);
    const FloatImage forgotten = inverses();
    EXPECT_EQ(differing(forgotten, before, true), 0);
    found.draw_forward(patches, textures, to);
    EXPECT_EQ(differing(inverses(), drawn, true), 0);
}

}  // namespace

namespace {

class GlPushPull : public Gl {
protected:
    /// Two eyes' pictures, filled at once, are those that the CPU fills one by one.
    void expect_the_cpus(const SourceView& main, std::span<const EyeView, 2> eyes,
                         std::span<const EyePicture, 2> before) {
        test::expect_the_cpus("pushpull", {.main = &main}, 55, eyes, before, targets, [&](const gl::EyeDepth& depth) {
            gaps.find(targets);
            push_pull.fill(main, eyes, depth, gaps, targets);
        });
    }

    gl::TargetsWithDepth targets;
    gl::GapTiles gaps;
    gl::PushPull push_pull;
};

/// Gaps of depths that nobody knows.
std::optional<float> depth_in_gap(int x, int y) {
    return (x + y) % 5 == 0 ? std::optional(std::nanf("")) : std::nullopt;
}

TEST_F(GlPushPull, FillsRandomPicturesAsTheCpuDoes) {
    const SourceView main{.camera = EquirectCamera{64, 32, {}}, .box_radius_m = 0.1};
    over_random_pictures(7, depth_in_gap,
                         [&](const auto& eyes, const auto& before) { expect_the_cpus(main, eyes, before); });
}

TEST_F(GlPushPull, TheBackgroundFillsWhatTheForegroundUncovered) {
    FillScene scene;
    const std::array eyes = {scene.eye, scene.eye};
    expect_the_cpus(scene.main_view, eyes, std::array{scene.unfilled, scene.unfilled});
    targets.download(0, scene.picture);
    EXPECT_LE(scene.worst_filled(PixelOrigin::push_pull), 26) << "red of the ball would show as 100 and more";
}

/// Nothing to take colours from in one eye does not hinder the other.
TEST_F(GlPushPull, AnEyeOfNothingButGapsStaysOne) {
    std::mt19937 random(5);
    const RandomPicture made(80, 40, random);
    const PerspectiveCamera camera{80, 40, 1};
    EyePicture empty;
    empty.reset(camera);
    const EyeView eye{camera, {}, made.depth_m.view()};
    expect_the_cpus({.camera = camera, .box_radius_m = 0.1}, std::array{eye, eye}, std::array{empty, made.picture});
    EyePicture found;
    targets.download(0, found);
    EXPECT_EQ(found.count(PixelOrigin::gap), 80 * 40);
}

}  // namespace
}  // namespace equistream::test
