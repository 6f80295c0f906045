#include <tests/unit/client/engine_scenes.h>
#include <tests/unit/evidence.h>

#include <tests/support/references/plain_engines.h>

#include <gtest/gtest.h>

#include <ostream>

namespace equistream::test {
namespace {

/// Darker with distance: what lies behind a silhouette never looks as what is before it does.
glm::dvec3 dimmed(const glm::dvec3& p, double distance_m) {
    return smooth(p, 3) / (1 + (std::isinf(distance_m) ? 3 : 0.5 * distance_m));
}

/// How alike an engine's pictures are to its reference's, over several eyes.
struct Likeness {
    double squares = 0;
    std::int64_t samples = 0, gaps_of_both = 0, gaps_of_either = 0;

    void add(const EyePicture& fast, const EyePicture& plain) {
        for (int y = 0; y < fast.origin.height(); ++y)
            for (int x = 0; x < fast.origin.width(); ++x) {
                const bool gap = *fast.origin.pixel(x, y) == 0, reference_gap = *plain.origin.pixel(x, y) == 0;
                gaps_of_both += gap && reference_gap;
                gaps_of_either += gap || reference_gap;
                for (int c = 0; c < 3 && !gap && !reference_gap; ++c, ++samples)
                    squares += std::pow(fast.rgba.pixel(x, y)[c] - plain.rgba.pixel(x, y)[c], 2);
            }
    }
    double psnr_db() const { return 10 * std::log10(255.0 * 255 * double(samples) / std::max(squares, 1.0)); }
    double agreement_of_gaps() const { return double(gaps_of_both) / double(gaps_of_either); }
};

EyePicture seen_by(const char* engine_name, const SourceView& source, const EyeView& eye, bool reference) {
    const auto engine = reference ? plain::make_engine(engine_name) : make_engine(engine_name);
    engine->set_source(source);
    EyePicture picture;
    engine->reproject(eye, picture);
    return picture;
}

/// What two ways to reckon the same may differ by where a sample lies on the very edge of a tolerance.
struct Expected {
    const char* engine;
    double min_psnr_db, min_agreement;

    friend std::ostream& operator<<(std::ostream& out, const Expected& expected) { return out << expected.engine; }
};

class FoundPictures : public testing::TestWithParam<Expected> {};

INSTANTIATE_TEST_SUITE_P(Client, FoundPictures,
                         testing::Values(Expected{"splat", 60, 0.97}, Expected{"mesh", 60, 0.97}),
                         [](const auto& test) { return std::string(test.param.engine); });

/// Depth alone would not tell whose colours a silhouette's pixels take.
TEST_P(FoundPictures, HaveTheReferencesColoursAndGaps) {
    const auto [engine, min_psnr_db, min_agreement] = GetParam();
    const SurfaceScene scene = furnished();
    const glm::dquat ahead = yaw_pitch(0.2, 0.1);
    for (const Camera& camera : engine_sources(360)) {
        const Rendered source = render(scene, dimmed, camera, Pose{{0.1, 0, 0}, ahead});
        Likeness gaps;
        for (const glm::dvec3& from : {glm::dvec3(0.1315, 0, 0), glm::dvec3(-0.063, 0, 0)}) {
            const EyeView eye{{120, 80, pi / 2}, {from, ahead}};
            const EyePicture fast = seen_by(engine, source.source(0.0315), eye, false);
            const EyePicture plain = seen_by(engine, source.source(0.0315), eye, true);
            Likeness colours;
            colours.add(fast, plain);
            gaps.add(fast, plain);
            EXPECT_GE(colours.psnr_db(), min_psnr_db)
                << camera.index() << " " << from.x << evidence(fast.rgb().view(), plain.rgb().view());
        }
        ASSERT_GT(gaps.gaps_of_either, 150) << camera.index();
        EXPECT_GE(gaps.agreement_of_gaps(), min_agreement) << camera.index();
    }
}

}  // namespace
}  // namespace equistream::test
