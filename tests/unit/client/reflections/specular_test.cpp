#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/client/simd_targets.h>
#include <tests/unit/evidence.h>

#include <client/fill/fill.h>
#include <client/reflections/specular.h>
#include <equistream/error.h>

#include <tests/support/references/plain_engines.h>

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <random>

namespace equistream::test {
namespace {

using glm::dvec3;

/// Painted once, as that takes most of a case's time.
const MirrorView& whole_sphere() {
    static const MirrorView view(EquirectCamera{2048, 1024, {}}, Pose{{0, 0, 0}, {1, 0, 0, 0}});
    return view;
}

struct Mirror : ::testing::Test {
    const PerspectiveCamera camera{320, 240, pi / 2};
    const Pose head{{0, 0, 0}, {1, 0, 0, 0}};
    const Pose eye_pose{{0.1, 0.08, 0.02}, yaw_pitch(0.05, -0.5)};
    MirrorView main = whole_sphere();
    MirrorView truth{camera, eye_pose};
    EyeView eye{camera, eye_pose, truth.picture.depth_m.view()};
    EyePicture picture;

    void reproject(const SourceView& source) {
        const auto engine = make_engine("surface");
        engine->set_source(source);
        engine->reproject(eye, picture);
    }
    /// Opens every mirror pixel whose image the main picture does not tell, or is not asked for, and fills them.
    double filled_db(const std::string& passes, const FillInputs& inputs,
                     MirrorTreatment treatment = MirrorTreatment::images) {
        reproject(*inputs.main);
        EXPECT_GT(rework_specular(*inputs.main, eye, picture, {.treatment = treatment}).gaps, 10000);
        const FillChain chain = make_fill_chain(passes);
        for (const auto& fill_pass : chain)
            fill_pass->set_frame(inputs);
        for (const auto& [name, count] : fill_gaps(chain, eye, picture))
            filled[name] = count;
        return mirror_psnr_db();
    }
    std::map<std::string, std::int64_t> filled;

    bool in_mirror(int x, int y) const { return *truth.specular.pixel(x, y) > 0.5f; }
    double mirror_psnr_db() const {
        double squares = 0, samples = 0;
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x)
                for (int c = 0; in_mirror(x, y) && c < 3; ++c) {
                    const double difference = picture.rgba.pixel(x, y)[c] - truth.picture.rgb.pixel(x, y)[c];
                    squares += difference * difference;
                    samples += 1;
                }
        return 10 * std::log10(255.0 * 255 * samples / squares);
    }
    std::string look() const { return evidence(picture.rgb().view(), truth.picture.rgb.view()); }
};

TEST_F(Mirror, ByVirtualDepthItIsExact) {
    const SourceView source = main.source();
    reproject(source);
    const double as_surface_db = mirror_psnr_db();
    const EyePicture before = picture;

    SourceView no_images = source;
    no_images.virtual_depth_m = {};
    const SpecularCounts hidden = rework_specular(no_images, eye, picture);
    EXPECT_EQ(hidden.by_image, 0);
    EXPECT_GT(hidden.gaps, 10000);
    const FillChain chain = make_fill_chain("pushpull");
    chain[0]->set_frame({.main = &source});
    fill_gaps(chain, eye, picture);
    const double filled_db = mirror_psnr_db();

    picture = before;
    const SpecularCounts counts = rework_specular(source, eye, picture);
    EXPECT_GT(counts.by_image, 10000);
    EXPECT_LT(counts.gaps, counts.by_image / 10);
    EXPECT_EQ(picture.count(PixelOrigin::gap), before.count(PixelOrigin::gap) + counts.gaps);
    fill_gaps(chain, eye, picture);
    const double by_image_db = mirror_psnr_db();
    RecordProperty("as_surface_db", std::to_string(as_surface_db));
    RecordProperty("filled_db", std::to_string(filled_db));
    RecordProperty("by_image_db", std::to_string(by_image_db));
    EXPECT_GT(by_image_db, as_surface_db + 10) << as_surface_db << " " << filled_db << " " << by_image_db << look();
    EXPECT_GT(by_image_db, filled_db + 10) << look();
}

/// Sources of every kind, with planes as renderers and streams leave them.
struct MirrorSearch : Mirror, ::testing::WithParamInterface<const char*> {
    MirrorView source_of(const std::string& kind) const {
        if (kind == "perspective")
            return {PerspectiveCamera{1600, 1200, 1.9}, {{0, 0, 0}, yaw_pitch(0, -0.6)}};
        if (kind == "partial")
            return {EquirectCamera{1536, 768, {-1.2, 1.2, -1.4, 0.6}}, head};
        return whole_sphere();
    }
    bool narrow() const { return GetParam() == std::string("narrow"); }
    /// Every pixel is one that an engine took from the source.
    void prepare() {
        const std::string kind = GetParam();
        // Odd, so that rows end within a vector.
        const PerspectiveCamera odd{narrow() ? 5 : 317, 239, narrow() ? 0.05 : pi / 2};
        main = source_of(kind);
        truth = MirrorView(odd, eye_pose);
        // A curved mirror's images in one half.
        for (int y = 0; y < main.image_m.height(); ++y)
            for (int x = 0; x < main.image_m.width() / 2; ++x)
                *main.image_m.pixel(x, y) *= float(1 + 0.1 * std::sin(0.02 * x));
        const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
        std::mt19937 random(5);
        if (kind == "broken")
            for (const float broken : {nan, 0.0f, -1.0f, infinity, 1e-20f, 1e30f})
                for (int i = 0; i < 4000; ++i) {
                    *main.image_m.pixel(int(random() % 2048), int(random() % 1024)) = broken;
                    *main.picture.depth_m.pixel(int(random() % 2048), int(random() % 1024)) = broken;
                    *truth.picture.depth_m.pixel(int(random() % 317), int(random() % 239)) =
                        i % 16 == 0 ? broken : 2.0f;
                }
        eye = {odd, eye_pose, truth.picture.depth_m.view()};
        picture.reset(odd);
        std::ranges::fill(picture.origin.samples(), std::uint8_t(PixelOrigin::source));
    }
};

TEST_P(MirrorSearch, EveryInstructionSetFindsWhatTheReferenceFinds) {
    prepare();
    const SourceView source = main.source();
    const EyePicture before = picture;
    const SpecularCounts expected = plain::rework_specular(source, eye, picture);
    const EyePicture plain = picture;
    EXPECT_GT(expected.by_image, narrow() ? 100 : 2000);
    for (const std::int64_t target : targets_here()) {
        const OnlyTarget only(target);
        picture = before;
        const SpecularCounts counts = rework_specular(source, eye, picture);
        int others = 0;
        for (int y = 0; y < picture.rgba.height(); ++y)
            for (int x = 0; x < picture.rgba.width(); ++x)
                others += !std::equal(picture.rgba.pixel(x, y), picture.rgba.pixel(x, y) + 3, plain.rgba.pixel(x, y),
                                      [](int a, int b) { return std::abs(a - b) <= 1; });
        // Positions are within 1e-4 samples of the reference's, so that about as many rays in ten thousand as they have
        // edges to pass may take the neighbouring sample.
        const std::int64_t few = expected.all() / 3000;
        EXPECT_LE(others, few) << target;
        EXPECT_LE(std::abs(counts.kept - expected.kept), few) << target;
        EXPECT_LE(std::abs(counts.by_image - expected.by_image), few) << target;
        EXPECT_LE(std::abs(counts.displaced - expected.displaced), few) << target;
        EXPECT_LE(std::abs(counts.gaps - expected.gaps), few) << target;
    }
}
TEST_P(MirrorSearch, EveryInstructionSetOpensWhatTheReferenceOpens) {
    prepare();
    const SourceView source = main.source();
    const EyePicture before = picture;
    const SpecularOptions gaps{.treatment = MirrorTreatment::gaps};
    const SpecularCounts by_images = plain::rework_specular(source, eye, picture);
    picture = before;
    const SpecularCounts expected = plain::rework_specular(source, eye, picture, gaps);
    const EyePicture plain = picture;
    EXPECT_EQ(expected.all(), by_images.all());
    EXPECT_GT(expected.gaps, narrow() ? 100 : 2000);
    EXPECT_LE(expected.kept, by_images.kept);
    const std::int64_t few = expected.all() / 3000;
    for (const std::int64_t target : targets_here()) {
        const OnlyTarget only(target);
        picture = before;
        const SpecularCounts counts = rework_specular(source, eye, picture, gaps);
        EXPECT_EQ(counts.by_image + counts.displaced, 0) << target;
        EXPECT_LE(std::abs(counts.kept - expected.kept), few) << target;
        EXPECT_LE(std::abs(counts.gaps - expected.gaps), few) << target;
        EXPECT_EQ(picture.count(PixelOrigin::gap), counts.gaps) << target;
        int others = 0, recoloured = 0;
        for (int y = 0; y < picture.origin.height(); ++y)
            for (int x = 0; x < picture.origin.width(); ++x) {
                const bool gap = *picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap);
                others += *picture.origin.pixel(x, y) != *plain.origin.pixel(x, y);
                recoloured += !gap && !std::equal(picture.rgba.pixel(x, y), picture.rgba.pixel(x, y) + 4,
                                                  before.rgba.pixel(x, y));
            }
        EXPECT_LE(others, few) << target;
        EXPECT_EQ(recoloured, 0) << target;
    }
}

INSTANTIATE_TEST_SUITE_P(Client, MirrorSearch,
                         ::testing::Values("sphere", "perspective", "partial", "narrow", "broken"),
                         [](const auto& test) { return std::string(test.param); });

TEST_F(Mirror, AsOnTheirSurfaceTheyStay) {
    const SourceView source = main.source();
    reproject(source);
    const EyePicture before = picture;
    EXPECT_EQ(rework_specular(source, eye, picture, {.treatment = MirrorTreatment::surface}).all(), 0);
    EXPECT_TRUE(std::ranges::equal(picture.rgba.samples(), before.rgba.samples()));
    EXPECT_TRUE(std::ranges::equal(picture.origin.samples(), before.origin.samples()));
}

TEST_F(Mirror, AsGapsOnlyWhatTellsOfItsImageIsKept) {
    const SourceView source = main.source();
    SourceView no_images = source;
    no_images.virtual_depth_m = {};
    // Far from a small box any image behind the surface would be within the budget.
    no_images.box_radius_m = 1e-5;
    const Pose near{{1e-5, 0, 0}, eye_pose.orientation};
    const MirrorView near_truth(camera, near);
    eye = {camera, near, near_truth.picture.depth_m.view()};
    reproject(no_images);
    const EyePicture before = picture;
    EXPECT_GT(rework_specular(no_images, eye, picture).kept, 10000);
    picture = before;
    const SpecularCounts counts = rework_specular(no_images, eye, picture, {.treatment = MirrorTreatment::gaps});
    EXPECT_EQ(counts.gaps, counts.all());
    EXPECT_GT(counts.gaps, 10000);
    no_images.virtual_depth_m = main.image_m.view();
    picture = before;
    const SpecularCounts told = rework_specular(no_images, eye, picture, {.treatment = MirrorTreatment::gaps});
    EXPECT_EQ(told.kept, counts.all());
}

TEST_F(Mirror, GapsAreFilledByAPictureThatShowsTheSame) {
    const SourceView source = main.source();
    const MirrorView own(EquirectCamera{2048, 1024, {}}, {eye_pose.position_m, {1, 0, 0, 0}});
    const MirrorView away(EquirectCamera{2048, 1024, {}}, {{-0.7, 0.3, 0.4}, {1, 0, 0, 0}});
    const auto filled_from = [&](const MirrorView& view) {
        SourceView small = view.source();
        small.specular = small.virtual_depth_m = {};
        return filled_db("small,pushpull", {.main = &source, .small = &small}, MirrorTreatment::gaps);
    };
    const double push_pull_db = filled_db("pushpull", {.main = &source}, MirrorTreatment::gaps);
    EXPECT_GT(filled_from(own), push_pull_db + 10) << look();
    EXPECT_GT(filled["small"], 10000);
    EXPECT_GE(filled_from(away), push_pull_db - 0.05) << look();
    EXPECT_LT(filled["small"], picture.count(PixelOrigin::push_pull) / 20);
}

TEST(MirrorTreatments, AreFoundByTheirNames) {
    for (std::size_t i = 0; i < mirror_treatment_names().size(); ++i)
        EXPECT_EQ(find_mirror_treatment(mirror_treatment_names()[i]), MirrorTreatment(i));
    EXPECT_THROW(find_mirror_treatment("always"), InputError);
}

TEST_F(Mirror, PlanesOfOtherSizesAreRefused) {
    const SourceView source = main.source();
    reproject(source);
    const FloatImage small(64, 32, 1, 1.0f);
    for (ImageView<const float> SourceView::*plane :
         {&SourceView::specular, &SourceView::depth_m, &SourceView::virtual_depth_m}) {
        SourceView wrong = source;
        wrong.*plane = small.view();
        EXPECT_THROW(rework_specular(wrong, eye, picture), InputError);
    }
    const EyeView wrong_eye{camera, eye_pose, small.view()};
    EXPECT_THROW(rework_specular(source, wrong_eye, picture), InputError);
}

TEST_F(Mirror, WhatIsNoMirrorIsLeftAlone) {
    const SourceView source = main.source();
    reproject(source);
    const EyePicture before = picture;
    rework_specular(source, eye, picture);
    int border = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            if (!in_mirror(x, y))
                border += !std::equal(picture.rgba.pixel(x, y), picture.rgba.pixel(x, y) + 4, before.rgba.pixel(x, y));
    // The source's mask is looked up at its nearest sample: pixels on the mirror's edge may be taken for it.
    EXPECT_LT(border, 600);
}

TEST_F(Mirror, AnEyeThatHardlyMovedKeepsItsPixels) {
    const Pose near{{0.0001, 0, 0}, eye_pose.orientation};
    MirrorView near_truth(camera, near);
    eye = {camera, near, near_truth.picture.depth_m.view()};
    SourceView source = main.source();
    source.box_radius_m = 0.0001;
    reproject(source);
    const EyePicture before = picture;
    const SpecularCounts counts = rework_specular(source, eye, picture);
    EXPECT_EQ(counts.by_image + counts.gaps, 0);
    EXPECT_GT(counts.kept, 10000);
    EXPECT_TRUE(std::ranges::equal(picture.rgba.samples(), before.rgba.samples()));
}

TEST_F(Mirror, WhereNoImageIsFoundLittleDisplacementIsKept) {
    // Stripes so narrow that the samples an image moves to are no mirror's.
    for (int y = 0; y < main.specular.height(); ++y)
        for (int x = 0; x < main.specular.width(); ++x)
            if (x % 64 > 1)
                *main.specular.pixel(x, y) = 0;
    const SourceView source = main.source();
    reproject(source);
    const EyePicture before = picture;
    const SpecularCounts far = rework_specular(source, eye, picture);
    EXPECT_GT(far.gaps, 200);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            if (*picture.origin.pixel(x, y) == *before.origin.pixel(x, y))
                continue;
            const dvec3 ray = glm::normalize(eye_pose.orientation * direction_of(camera, x + 0.5, y + 0.5));
            const dvec3 d = glm::normalize(eye_pose.position_m + double(*truth.picture.depth_m.pixel(x, y)) * ray);
            if (!MirrorRoom::mirrors(MirrorRoom::depth({}, d) * d))
                continue;  // its nearest sample is on the mirror, just across the edge
            const dvec3 image = MirrorRoom::image_depth({}, d) * d - eye_pose.position_m;
            EXPECT_GT(glm::degrees(std::asin(glm::length(glm::cross(glm::normalize(image), ray)))), 0.9)
                << x << " " << y;
        }

    const Pose near{{0.015, 0.01, 0}, eye_pose.orientation};
    const MirrorView near_truth(camera, near);
    eye = {camera, near, near_truth.picture.depth_m.view()};
    reproject(source);
    const EyePicture near_before = picture;
    const SpecularCounts little = rework_specular(source, eye, picture);
    EXPECT_EQ(little.gaps, 0);
    EXPECT_GT(little.displaced, 200);
    EXPECT_EQ(picture.count(PixelOrigin::gap), near_before.count(PixelOrigin::gap));
}

TEST_F(Mirror, WithoutImagesOtherPicturesPassItOver) {
    SourceView source = main.source();
    source.virtual_depth_m = {};
    const double push_pull_db = filled_db("pushpull", {.main = &source});
    // Earlier frames have masks as main has; a second eye's view has none of its own.
    const MirrorView before(EquirectCamera{2048, 1024, {}}, {{-0.7, 0.3, 0.4}, {1, 0, 0, 0}});
    SourceView earlier = before.source();
    earlier.virtual_depth_m = {};
    SourceView small = before.source();
    small.specular = small.virtual_depth_m = {};
    for (const bool masked : {true, false}) {
        const double db = masked ? filled_db("earlier,pushpull", {.main = &source, .earlier = {&earlier, 1}})
                                 : filled_db("small,pushpull", {.main = &source, .small = &small});
        EXPECT_GE(db, push_pull_db - 0.05) << masked << look();
        // Few at most: what the eye uncovered beside the mirror's edges may come from there, the mirror itself not.
        EXPECT_LT(filled[masked ? "earlier" : "small"], picture.count(PixelOrigin::push_pull) / 20);
    }
    // Taken as if it were painted on the surface, the mirror would be wrong: the test can fail.
    SourceView unaware = source;
    unaware.specular = {};
    reproject(source);
    rework_specular(source, eye, picture);
    const FillChain chain = make_fill_chain("small,pushpull");
    for (const auto& fill_pass : chain)
        fill_pass->set_frame({.main = &unaware, .small = &small});
    fill_gaps(chain, eye, picture);
    EXPECT_LT(mirror_psnr_db(), push_pull_db - 1);
}

TEST_F(Mirror, APictureFromTheEyesOwnPlaceIsRightInIt) {
    SourceView source = main.source();
    source.virtual_depth_m = {};
    const double push_pull_db = filled_db("pushpull", {.main = &source});
    const MirrorView own(EquirectCamera{2048, 1024, {}}, {eye_pose.position_m, {1, 0, 0, 0}});
    SourceView small = own.source();
    small.specular = small.virtual_depth_m = {};
    EXPECT_GT(filled_db("small,pushpull", {.main = &source, .small = &small}), push_pull_db + 10) << look();
    EXPECT_GT(filled["small"], 10000);
}

TEST(ImageColours, AreOfSamplesThatShowOneImage) {
    ByteImage rgb(16, 8, 3);
    FloatImage specular(16, 8, 1, 1.0f), image_m(16, 8, 1, 4.0f);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x) {
            std::fill_n(rgb.pixel(x, y), 3, std::uint8_t(10 * x + y));
            *specular.pixel(x, y) = x < 8 ? 1.0f : 0.0f;
        }
    const SourceView source{.rgb = rgb.view(),
                            .camera = EquirectCamera{16, 8, {}},
                            .specular = specular.view(),
                            .virtual_depth_m = image_m.view()};
    const ImageColour colour(source, {0.1f, 1e-3f});
    EXPECT_NEAR(colour.at({4.75f, 3.75f}).x, 42.5 + 3.25, 1e-3) << "all four";
    EXPECT_NEAR(colour.at({7.9f, 3.75f}).x, 70 + 3.25, 1e-3) << "column 8 is no mirror";
    std::fill_n(image_m.pixel(0, 4), 16 * 4, 9.0f);
    EXPECT_NEAR(colour.at({4.75f, 3.9f}).x, 42.5 + 3, 1e-3) << "row 4 shows another image";
    std::fill_n(image_m.pixel(0, 5), 16 * 3, 4.0f);
    EXPECT_NEAR(colour.at({4.75f, 3.9f}).x, 42.5 + 3, 1e-3) << "row 4 alone does";
    std::fill_n(image_m.pixel(0, 4), 16, 4.0f);
    for (int y = 0; y < 8; ++y)
        *image_m.pixel(5, y) = 9.0f;
    EXPECT_NEAR(colour.at({4.9f, 3.75f}).x, 40 + 3.25, 1e-3) << "column 5 alone does";
}

}  // namespace
}  // namespace equistream::test
