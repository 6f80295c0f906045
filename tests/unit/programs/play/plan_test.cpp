/// `play --method auto`: which ways there are, and that their order is the one measured.
#include <programs/play/choice.h>

#include <client/fill/fill.h>
#include <client/stages/stages.h>
#include <equistream/bound.h>
#include <tests/unit/client/analytic_scene.h>

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <map>

namespace equistream::play {
namespace {

using equistream::test::Rendered;
using glm::dvec3;
namespace test = equistream::test;

const Pose source_pose, moved{{0.063, 0.02, 0}, {1, 0, 0, 0}};

TEST(Plans, AskOnlyForWhatIsThereOnceEach) {
    for (const char* fill :
         {"hidden,patches,earlier,small,small-wide,geometry,pushpull", "patches,small", "pushpull", "none"})
        for (const unsigned there : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u}) {
            const PlanInputs inputs{.geometry = (there & 1) != 0,
                                    .streamed_depth = (there & 2) != 0,
                                    .poses = (there & 4) != 0,
                                    .fill = fill};
            const std::vector<std::string> chains = shorter_chains(inputs.fill, inputs.idle_passes);
            const std::vector<Plan> plans = plans_by_accuracy(inputs);
            ASSERT_FALSE(plans.empty());
            EXPECT_EQ(plans.back().words(), "rotation, depth none, fill none");
            for (const Plan& plan : plans) {
                SCOPED_TRACE(plan.words());
                EXPECT_EQ(std::ranges::count(plans, plan), 1);
                const DepthNeeds needs = make_engine(plan.method)->needs_depth(source_pose, moved);
                EXPECT_EQ(plan.depth != "none", needs.any());
                EXPECT_TRUE(inputs.geometry || !(needs.eye || plan.depth == "ray"));
                EXPECT_TRUE(inputs.streamed_depth || plan.depth != "stream");
                EXPECT_TRUE(inputs.poses || (!needs.any() && plan.method != "proxy-sphere"));
                EXPECT_TRUE(std::ranges::count(chains, plan.fill) > 0 || plan.fill == "none") << plan.fill;
            }
        }
}

TEST(Plans, AreAsManyAsDecision15Says) {
    PlanInputs inputs{.geometry = true, .fill = default_fill};
    EXPECT_EQ(plans_by_accuracy(inputs).size(), 11u);
    inputs.streamed_depth = true;
    EXPECT_EQ(plans_by_accuracy(inputs).size(), 16u);
    inputs.geometry = false;
    EXPECT_EQ(plans_by_accuracy(inputs).size(), 8u);
}

TEST(Plans, ShowWhatLiesAroundAWindowHoweverLittleTimeThereIs) {
    PlanInputs inputs{.streamed_depth = true, .fill = default_fill};
    for (const Plan& plan : plans_by_accuracy(inputs))
        EXPECT_NE(plan.fill.find("base"), std::string::npos) << plan.words();
    EXPECT_EQ(plans_by_accuracy(inputs).back().words(), "rotation, depth none, fill base");
    inputs.idle_passes = {"base"};
    const std::vector<Plan> without_window = plans_by_accuracy(inputs);
    for (const Plan& plan : without_window)
        EXPECT_TRUE(plan.fill == default_fill || plan.fill.find("base") == std::string::npos) << plan.words();
    EXPECT_EQ(without_window.back().words(), "rotation, depth none, fill none");
}

/// Depth that OpenGL draws takes the place of rays, and leaves the stream's own depth undecoded as they do.
TEST(Plans, CastDepthAsTheyAreTold) {
    for (const std::string depth : {"ray", "gl", "gl-cube"}) {
        const Plan first = plans_by_accuracy({.geometry = true, .cast = depth, .fill = "none"}).front();
        EXPECT_EQ(first.words(), "eye-depth, depth " + depth + ", fill none");
        EXPECT_TRUE(unneeded_roles(first.choice())[std::size_t(TrackRole::depth)]);
    }
    EXPECT_FALSE(unneeded_roles({.engine = "mesh", .depth = "stream", .fill = "none"})[std::size_t(TrackRole::depth)]);
}

TEST(Plans, AreBarredOnlyByTracksThatCame) {
    const PlanInputs inputs{
        .geometry = true, .streamed_depth = true, .fill = default_fill, .idle_passes = {"hidden", "patches"}};
    const std::vector<Plan> plans = plans_by_accuracy(inputs);
    TrackRoles came;
    came.set(std::size_t(TrackRole::main));
    // Without tracks to leave out nothing is barred, whatever comes first.
    for (const Plan& chosen : plans)
        EXPECT_EQ(plans_after(plans, chosen, came), plans) << chosen.words();
    // The depth track, which the slowest start leaves out, bars only what takes depth from it.
    came.set(std::size_t(TrackRole::depth));
    const auto takes_it = [](const Plan& plan) { return plan.depth == "stream"; };
    EXPECT_EQ(plans_after(plans, plans.front(), came).size(),
              plans.size() - std::size_t(std::ranges::count_if(plans, takes_it)));
    EXPECT_TRUE(std::ranges::none_of(plans_after(plans, plans.back(), came), takes_it));
    // Mirrors are looked up by depth: once they are left out, so is all that has depth.
    came.set(std::size_t(TrackRole::reflections));
    for (const Plan& plan : plans_after(plans, plans.back(), came))
        EXPECT_EQ(plan.depth, "none") << plan.words();
    came = {};
    came.set(std::size_t(TrackRole::hidden));
    const Plan without_hidden{.method = "eye-depth", .depth = "ray", .fill = "pushpull"};
    for (const Plan& plan : plans_after(plans, without_hidden, came))
        EXPECT_FALSE(plan.fill.starts_with("hidden") && plan.depth != "none") << plan.words();
}

TEST(Plans, NeedToKnowOfMirrorsOnlyWhereSomethingAsksForThem) {
    const auto needs_images = [](const Plan& plan) {
        return !unneeded_roles(plan.choice())[std::size_t(TrackRole::reflections)];
    };
    for (const char* by_points : {"hidden", "patches", "earlier", "small", "small-wide,pushpull"})
        EXPECT_TRUE(needs_images({.method = "mesh", .depth = "ray", .fill = by_points, .mirrors = false}));
    for (const char* otherwise : {"none", "pushpull", "geometry,spread"}) {
        EXPECT_FALSE(needs_images({.method = "mesh", .depth = "ray", .fill = otherwise, .mirrors = false}));
        EXPECT_TRUE(needs_images({.method = "mesh", .depth = "ray", .fill = otherwise}));
    }
    EXPECT_FALSE(needs_images({.method = "proxy-sphere", .depth = "none", .fill = "small"})) << "nothing has depth";
    for (const bool mirrors : {false, true})
        for (const Plan& plan :
             plans_by_accuracy({.geometry = true, .streamed_depth = true, .fill = "pushpull", .mirrors = mirrors}))
            EXPECT_EQ(needs_images(plan), mirrors && plan.depth != "none") << plan.words();
}

/// Balls before a wall, textured, from a sphere whose streamed depth has 8 bits of w; behind the balls the hidden
/// layer, and frames before from where the head came from.
class Accuracy {
public:
    Accuracy()
        : source_(test::render(distance, colour, sphere, source_pose)),
          hidden_(test::render(second_distance, colour, sphere, source_pose)),
          earlier_(test::render(distance, colour, sphere, Pose{{-0.04, -0.02, 0.02}, {1, 0, 0, 0}})) {
        for (float& r : hidden_.depth_m.samples())
            if (std::isinf(r))
                r = std::numeric_limits<float>::quiet_NaN();
        for (const dvec3& way_m : {dvec3(0.063, 0, 0), {-0.063, 0, 0}, {0.03, 0.05, 0}, {-0.04, -0.03, 0.03}}) {
            Truth truth{{way_m, {1, 0, 0, 0}}};
            truth.picture = test::render(distance, colour, eye_camera, truth.pose);
            truths_.push_back(std::move(truth));
        }
        coded_ = source_.depth_m;
        const double step = bounded_inverse_depth(0.8, box_m) / 255;
        for (float& r : coded_.samples()) {
            const double w = step * std::round(bounded_inverse_depth(double(r), box_m) / step);
            r = float(w > 0 ? box_m + box_m / w : test::infinity);
        }
    }

    /// Over all eyes.
    double psnr_db(const Plan& plan) const {
        SourceView source = source_.source(box_m);
        if (plan.depth == "stream")
            source.depth_m = coded_.view();
        const auto engine = make_engine(plan.method);
        const FillChain chain = make_fill_chain(plan.fill);
        engine->set_source(source);
        const SourceView hidden = hidden_.source(box_m), earlier = earlier_.source(box_m);
        for (const auto& fill_pass : chain)
            fill_pass->set_frame({.main = &source, .earlier = {&earlier, 1}, .hidden = &hidden});
        double squares = 0, samples = 0;
        for (const Truth& truth : truths_) {
            const EyeView eye{eye_camera, truth.pose, truth.picture.depth_m.view()};
            EyePicture picture;
            engine->reproject(eye, picture);
            fill_gaps(chain, eye, picture);
            const ByteImage rgb = picture.rgb();
            for (std::size_t i = 0; i < rgb.samples().size(); ++i, ++samples)
                squares += std::pow(double(rgb.samples()[i]) - double(truth.picture.rgb.samples()[i]), 2);
        }
        return 10 * std::log10(255 * 255 * samples / squares);
    }

private:
    static std::array<double, 4> distances(const dvec3& o, const dvec3& d) {
        std::array all = {test::to_sphere(o, d, {0.3, 0, -1.5}, 0.4), test::to_sphere(o, d, {-0.5, 0.2, -1}, 0.15),
                          test::to_plane(o, d, {0, 0, 1}, -3), test::to_plane(o, d, {0, 1, 0}, -1)};
        std::ranges::sort(all);
        return all;
    }
    static double distance(const dvec3& o, const dvec3& d) { return distances(o, d)[0]; }
    static double second_distance(const dvec3& o, const dvec3& d) { return distances(o, d)[1]; }
    static dvec3 colour(const dvec3& p, double) { return test::smooth(p, 20); }

    static constexpr double box_m = 0.07;
    inline static const EquirectCamera sphere{1280, 640, {}};
    inline static const PerspectiveCamera eye_camera{320, 200, pi / 2};

    struct Truth {
        Pose pose;
        test::Rendered picture{};
    };
    test::Rendered source_, hidden_, earlier_;
    FloatImage coded_;
    std::vector<Truth> truths_;
};

/// A tenth of a decibel is what a depth code may lose: ways that near each other are as good. With the eyes' own depth
/// and without are two orders, as how much passes are worth beside it is the scene's; with the same passes it is ahead.
TEST(Plans, ComeInTheOrderOfWhatTheyMeasure) {
    constexpr double as_good_db = 0.1;
    const Accuracy accuracy;
    double worst_by_eye_db = 99, worst_without_db = 99;
    std::map<std::string, double> by_eye_db;
    for (const Plan& plan :
         plans_by_accuracy({.geometry = true, .streamed_depth = true, .fill = "hidden,earlier,pushpull"})) {
        const bool by_eye = plan.method == "eye-depth";
        const double db = accuracy.psnr_db(plan);
        double& worst_yet_db = by_eye ? worst_by_eye_db : worst_without_db;
        EXPECT_LE(db, worst_yet_db + as_good_db) << plan.words();
        worst_yet_db = std::min(worst_yet_db, db);
        const double same_passes_db = by_eye_db.try_emplace(plan.fill, by_eye ? db : 99).first->second;
        EXPECT_LE(db, same_passes_db + as_good_db) << plan.words();
    }
    EXPECT_LT(worst_without_db, 20);
}

TEST(Plans, LeavePassesOutOneAtATimeTheLeastWorthFirst) {
    using Chains = std::vector<std::string>;
    EXPECT_EQ(shorter_chains("hidden,patches,earlier,pushpull", {}),
              (Chains{"hidden,patches,earlier,pushpull", "hidden,patches,pushpull", "hidden,pushpull", "pushpull"}));
    EXPECT_EQ(shorter_chains("small-wide,patches,small,geometry,spread", {}),
              (Chains{"small-wide,patches,small,geometry,spread", "small-wide,patches,geometry,spread",
                      "patches,geometry,spread", "patches,spread", "spread"}));
    // What fills nothing makes no chain of its own.
    EXPECT_EQ(shorter_chains("hidden,patches,earlier,pushpull", {"patches", "small"}),
              (Chains{"hidden,patches,earlier,pushpull", "hidden,pushpull", "pushpull"}));
    EXPECT_EQ(shorter_chains("hidden,patches,pushpull", {"patches", "hidden"}), Chains{"hidden,patches,pushpull"});
    // A guess goes before what is truly there, wherever it stands.
    EXPECT_EQ(shorter_chains("hidden,spread,pushpull", {}),
              (Chains{"hidden,spread,pushpull", "hidden,pushpull", "pushpull"}));
    EXPECT_EQ(shorter_chains("pushpull,small,spread", {}), (Chains{"pushpull,small,spread", "small,spread", "spread"}));
    EXPECT_EQ(shorter_chains("earlier", {}), Chains{"earlier"});
    EXPECT_EQ(shorter_chains("none", {}), Chains{"none"});
}

}  // namespace
}  // namespace equistream::play
