/// `play --method auto`: which ways there are, that their order is the one measured, and which of them is taken.
#include "analytic_scene.h"

#include "programs/play/plan.h"

#include <equistream/bound.h>
#include <equistream/formatted.h>
#include <equistream_client/fill.h>

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace equistream::play {
namespace {

using glm::dvec3;

const Pose source_pose, moved{{0.063, 0.02, 0}, {1, 0, 0, 0}};

/// All that there can be to choose from, with ladders of several rungs, of one and of none.
std::vector<PlanInputs> all_inputs() {
    std::vector<PlanInputs> all;
    for (const char* fill : {"patches,small,pushpull", "pushpull", "none"})
        for (const unsigned there : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u})
            all.push_back({.geometry = (there & 1) != 0,
                           .streamed_depth = (there & 2) != 0,
                           .poses = (there & 4) != 0,
                           .fill = fill});
    return all;
}

TEST(Plans, AskOnlyForWhatIsThere) {
    for (const PlanInputs& inputs : all_inputs())
        for (const Plan& plan : plans_by_accuracy(inputs)) {
            SCOPED_TRACE(plan.words());
            const DepthNeeds needs = make_engine(plan.method)->needs_depth(source_pose, moved);
            EXPECT_EQ(plan.depth != "none", needs.any());
            EXPECT_TRUE(inputs.geometry || !(needs.eye || plan.depth == "ray"));
            EXPECT_TRUE(inputs.streamed_depth || plan.depth != "stream");
            EXPECT_TRUE(inputs.poses || (!needs.any() && plan.method != "lean"));
            // A ladder is climbed whole, by its last rung alone, or not at all.
            EXPECT_TRUE(plan.fill == inputs.fill || plan.fill == "none" || plan.fill == "pushpull") << plan.fill;
        }
}

TEST(Plans, AreTriedOnceEachAndEndWithWhatAlwaysPlays) {
    for (const PlanInputs& inputs : all_inputs()) {
        const std::vector<Plan> plans = plans_by_accuracy(inputs);
        std::set<std::string> words;
        for (const Plan& plan : plans)
            EXPECT_TRUE(words.insert(plan.words()).second) << plan.words() << " twice";
        ASSERT_FALSE(plans.empty());
        EXPECT_EQ(plans.back().depth, "none");
        EXPECT_EQ(plans.back().fill, "none");
    }
}

/// A ball and a bar before a wall, textured, from a sphere whose streamed depth has 8 bits of w.
class Accuracy {
public:
    Accuracy() : source_(test::render(distance, colour, EquirectCamera{1280, 640, {}}, source_pose)) {
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
        const auto engine = make_engine(plan.method, {.mesh_share = plan.mesh_share});
        const FillLadder ladder = make_fill_ladder(plan.fill);
        engine->set_source(source);
        for (const auto& rung : ladder)
            rung->set_frame({.main = &source});
        double squares = 0, samples = 0;
        for (const Truth& truth : truths_) {
            const EyeView eye{eye_camera, truth.pose, truth.picture.depth_m.view()};
            EyePicture picture;
            engine->reproject(eye, picture);
            fill_gaps(ladder, eye, picture);
            const ByteImage rgb = picture.rgb();
            for (std::size_t i = 0; i < rgb.samples().size(); ++i, ++samples)
                squares += std::pow(double(rgb.samples()[i]) - double(truth.picture.rgb.samples()[i]), 2);
        }
        return 10 * std::log10(255 * 255 * samples / squares);
    }

private:
    static double distance(const dvec3& o, const dvec3& d) {
        return std::min({test::to_sphere(o, d, {0.3, 0, -1.5}, 0.4), test::to_sphere(o, d, {-0.5, 0.2, -1}, 0.15),
                         test::to_plane(o, d, {0, 0, 1}, -3), test::to_plane(o, d, {0, 1, 0}, -1)});
    }
    static dvec3 colour(const dvec3& p, double) { return test::smooth(p, 20); }

    static constexpr double box_m = 0.07;
    inline static const PerspectiveCamera eye_camera{320, 200, pi / 2};

    struct Truth {
        Pose pose;
        test::Rendered picture{};
    };
    test::Rendered source_;
    FloatImage coded_;
    std::vector<Truth> truths_;
};

/// A tenth of a decibel is what a depth code may lose: ways that near each other are as good.
TEST(Plans, ComeInTheOrderOfWhatTheyMeasure) {
    constexpr double as_good_db = 0.1;
    const Accuracy accuracy;
    for (const bool geometry : {true, false}) {
        double worst_yet_db = 99;
        for (const Plan& plan :
             plans_by_accuracy({.geometry = geometry, .streamed_depth = true, .fill = "spread,pushpull"})) {
            const double db = accuracy.psnr_db(plan);
            EXPECT_LE(db, worst_yet_db + as_good_db) << plan.words();
            worst_yet_db = std::min(worst_yet_db, db);
        }
    }
}

/// Times that have nothing to do with the order, and budgets between, below and above them.
TEST(Choices, TakeTheFirstThatFitsElseTheFastestAndSayWhich) {
    std::mt19937 random(11);
    const auto text = [](double ms) { return formatted("%.1f ms", ms); };
    for (int i = 0; i < 300; ++i) {
        const std::vector<PlanInputs> all = all_inputs();
        const std::vector<Plan> plans = plans_by_accuracy(all[random() % all.size()]);
        std::vector<double> times_ms(plans.size());
        for (double& ms : times_ms)
            ms = 1 + double(random() % 400) / 10;
        const double budget_ms = double(random() % 450) / 10;
        std::size_t measured = 0;
        const Choice choice = choose_plan(plans, budget_ms, [&](const Plan& plan) {
            EXPECT_EQ(plan.words(), plans[measured].words());
            return Trial{times_ms[measured++]};
        });
        const std::string line = choice.line();
        const auto first = std::ranges::find_if(times_ms, [&](double ms) { return ms <= budget_ms; });
        EXPECT_EQ(choice.fits, first != times_ms.end());
        const auto taken = choice.fits ? first : std::ranges::min_element(times_ms);
        const auto at = std::size_t(taken - times_ms.begin());
        ASSERT_EQ(choice.chosen, at) << line;
        EXPECT_EQ(choice.tried.size(), choice.fits ? at + 1 : plans.size());  // no more than needed
        EXPECT_EQ(measured, choice.tried.size());
        EXPECT_EQ(line.rfind(plans[at].words() + ": " + text(times_ms[at]) + " of ", 0), 0u) << line;
        EXPECT_EQ(line.find("nothing fits") != line.npos, !choice.fits) << line;
        if (choice.fits && at > 0) {
            EXPECT_NE(line.find(plans[at - 1].words() + ", " + text(times_ms[at - 1])), line.npos) << line;
        }
    }
}

}  // namespace
}  // namespace equistream::play
