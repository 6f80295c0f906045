/// Hidden points (resample.h) where pictures end or go round: what fill passes take there, against the plain
/// `eye-depth`.
#include <tests/unit/client/analytic_scene.h>

#include <client/fill/fill.h>
#include <equistream/patches.h>

#include <tests/support/references/plain_engines.h>

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace equistream::test {
namespace {

using glm::dvec3;

/// Above and below the source, which sees nothing behind them.
double floor_and_ceiling(const dvec3& o, const dvec3& d) {
    return std::min(to_plane(o, d, {0, 1, 0}, -1.6), to_plane(o, d, {0, 1, 0}, 1.6));
}

/// Tilted: partly behind floor and ceiling, within half a pixel of them where it crosses, and before them beyond.
double tilted_planes(const dvec3& o, const dvec3& d) {
    return std::min(to_plane(o, d, {0.3, 1, 0.2}, -2), to_plane(o, d, {-0.2, 1, 0.3}, 2));
}

double hidden_planes(const dvec3& o, const dvec3& d) {
    return std::min(to_plane(o, d, {0, 1, 0}, -3), to_plane(o, d, {0, 1, 0}, 3));
}

dvec3 smooth_colour(const dvec3& p, double) {
    return smooth(p, 1.5);
}

/// No pole of the sphere is right above or below: depth differs all round it.
const Pose source_pose{{0, 0, 0}, yaw_pitch(0.2, 0.5)};
/// Where the sixteen samples around a position lie.
enum class Around { inside, round_the_seam, beyond_the_end };

Around around(const Camera& camera, const dvec3& direction) {
    const glm::dvec2 first = glm::floor(pixel_of(camera, direction) - 0.5) - 1.0;
    const auto is_within = [](double begin, int count) { return begin >= 0 && begin + 3 < count; };
    if (!is_within(first.y, height_of(camera)))
        return Around::beyond_the_end;
    if (is_within(first.x, width_of(camera)))
        return Around::inside;
    return columns_close(camera) ? Around::round_the_seam : Around::beyond_the_end;
}

struct Eye {
    PerspectiveCamera camera{160, 100, pi / 2};
    Pose pose;
    FloatImage depth_m{camera.width, camera.height, 1};

    Eye(const Distance& distance, const glm::dquat& turn, double fov_rad)
        : pose{{0.5, 0.1, -0.3}, source_pose.orientation * turn} {
        camera.fov_x_rad = fov_rad;
        AnalyticDepth(distance).cast(camera, pose, depth_m.view());
    }
    EyeView view() const { return {camera, pose, depth_m.view()}; }
    Around around(const Camera& source, int x, int y) const {
        const dvec3 ray = pose.orientation * camera.direction(x + 0.5, y + 0.5);
        const double r = *depth_m.pixel(x, y);
        const dvec3 from_source = std::isinf(r) ? ray : pose.position_m + r * ray;
        return test::around(source, glm::conjugate(source_pose.orientation) * from_source);
    }
};

EyePicture by_reference(const SourceView& source, const Eye& eye) {
    const auto engine = plain::make_engine("surface");
    engine->set_source(source);
    EyePicture picture;
    engine->reproject(eye.view(), picture);
    return picture;
}

EyePicture by_pass(const char* fill_pass, const FillInputs& inputs, const Eye& eye) {
    const FillChain chain = make_fill_chain(fill_pass);
    chain[0]->set_frame(inputs);
    EyePicture picture;
    picture.reset(eye.camera);
    chain[0]->fill(eye.view(), picture);
    return picture;
}

struct Differences {
    int pixels = 0, uncoloured = 0;         ///< by the reference
    int only_pass = 0, only_reference = 0;  ///< coloured by one of the two
    int worst = 0;                          ///< of 255, of those that both coloured
};

/// By where the samples lie.
using DifferencesAround = std::array<Differences, 3>;

void compare(const EyePicture& fill_pass, const SourceView& source, const Eye& eye, DifferencesAround& found) {
    const EyePicture reference = by_reference(source, eye);
    for (int y = 0; y < eye.camera.height; ++y)
        for (int x = 0; x < eye.camera.width; ++x) {
            Differences& here = found[std::size_t(eye.around(source.camera, x, y))];
            const bool is_passes = *fill_pass.origin.pixel(x, y) != std::uint8_t(PixelOrigin::gap);
            const bool is_references = *reference.origin.pixel(x, y) != std::uint8_t(PixelOrigin::gap);
            ++here.pixels;
            here.uncoloured += !is_references;
            here.only_pass += is_passes && !is_references;
            here.only_reference += is_references && !is_passes;
            for (int c = 0; c < 3 && is_passes && is_references; ++c)
                here.worst =
                    std::max(here.worst, std::abs(fill_pass.rgba.pixel(x, y)[c] - reference.rgba.pixel(x, y)[c]));
        }
}

/// Of points that the source sees, that it does not, and of both; ahead, along the seam and about both poles, wide and
/// narrow. `look` is what is tested: look(eye) makes a picture.
template <typename Look>
DifferencesAround differences(const SourceView& source, const Look& look) {
    DifferencesAround found;
    for (const Distance& distance : {Distance(floor_and_ceiling), Distance(hidden_planes), Distance(tilted_planes)})
        for (const glm::dquat& turn :
             {yaw_pitch(0, -0.4), yaw_pitch(pi, -0.4), yaw_pitch(pi, 0.5), yaw_pitch(0.3, 1.4), yaw_pitch(-2, -1.4)})
            for (const double fov_rad : {pi / 2, 0.5}) {
                const Eye eye(distance, turn, fov_rad);
                compare(look(eye), source, eye, found);
            }
    return found;
}

/// Decisions on the tolerance's very edge may fall either way in single precision. Beyond rows a fill pass lets nothing
/// hide, since patches end anywhere: it may colour more than the reference there, but nothing else.
void expect_alike(const DifferencesAround& found) {
    for (const Around where : {Around::inside, Around::round_the_seam, Around::beyond_the_end}) {
        const Differences& here = found[std::size_t(where)];
        EXPECT_LE(here.only_reference, 2) << int(where);
        EXPECT_LE(here.only_pass, where == Around::beyond_the_end ? here.pixels / 100 : 2) << int(where);
    }
}

TEST(HiddenPoints, OfPicturesAreTheReferencesRoundTheSeamAndUpToTheEnds) {
    const EquirectCamera part{96, 64, {-pi / 2, pi / 2, -1, 1}};
    for (const Camera& camera : {Camera(EquirectCamera{180, 90, {}}), Camera(EquirectCamera{60, 30, {}}), Camera(part),
                                 Camera(PerspectiveCamera{160, 120, 2.4})}) {
        SCOPED_TRACE(std::to_string(width_of(camera)) + " columns");
        const Rendered source = render(floor_and_ceiling, smooth_colour, camera, source_pose);
        const SourceView view = source.source(0.6);
        const DifferencesAround found =
            differences(view, [&](const Eye& eye) { return by_pass("small", {.main = &view, .small = &view}, eye); });
        expect_alike(found);
        for (const Differences& here : found)
            EXPECT_LE(here.worst, 1);
        const Differences& ends = found[std::size_t(columns_close(camera) ? Around::round_the_seam : Around::inside)];
        EXPECT_GT(ends.uncoloured, 5000);
        EXPECT_GT(ends.pixels - ends.uncoloured, 5000);
    }
}

TEST(HiddenPoints, OfPatchesAreTheReferencesRoundTheSeamAndUpToTheEnds) {
    const EquirectCamera sphere{180, 90, {}};
    const Rendered source = render(floor_and_ceiling, smooth_colour, sphere, source_pose);
    // Every block of it, those at the right and lower border cut.
    PatchAtlas atlas;
    atlas.sphere_width = sphere.width;
    atlas.sphere_height = sphere.height;
    atlas.offsets_m = {{0, 0, 0}};
    atlas.columns = atlas.block_columns();
    atlas.rows = atlas.block_rows();
    for (int y = 0; y < atlas.rows; ++y)
        for (int x = 0; x < atlas.columns; ++x)
            atlas.slots.push_back({0, std::uint16_t(x), std::uint16_t(y), true});
    ByteImage rgb(atlas.width(), atlas.height(), 3);
    FloatImage depth_m(atlas.width(), atlas.height(), 1, std::nanf(""));
    for (int y = 0; y < sphere.height; ++y)
        for (int x = 0; x < sphere.width; ++x) {
            std::copy_n(source.rgb.pixel(x, y), 3, rgb.pixel(x, y));
            *depth_m.pixel(x, y) = *source.depth_m.pixel(x, y);
        }
    const SourceView view = source.source(0.6);
    const PatchesView patches{.rgb = rgb.view(),
                              .depth_m = depth_m.view(),
                              .atlas = &atlas,
                              .pose = source_pose,
                              .box_radius_m = view.box_radius_m};
    expect_alike(differences(
        view, [&](const Eye& eye) { return by_pass("patches", {.main = &view, .patches = &patches}, eye); }));
}

}  // namespace
}  // namespace equistream::test
