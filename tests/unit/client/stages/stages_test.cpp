/// The stages table says what its stages are.
#include <client/stages/stages.h>
#include <equistream/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace {

using namespace equistream;

template <typename Row>
void expect_told_apart(std::span<const Row> rows) {
    std::set<std::string_view> names;
    for (const Row& row : rows) {
        EXPECT_TRUE(names.insert(row.name).second) << row.name << " twice";
        EXPECT_TRUE(row.old_name.empty() || names.insert(row.old_name).second) << row.old_name << " twice";
        EXPECT_FALSE(row.help.empty()) << row.name;
        EXPECT_EQ(row.help.find_first_of("()"), row.help.npos) << row.name << ": help stands in brackets";
    }
}

template <typename Function>
std::string complaint(const Function& function) {
    try {
        function();
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST(Stages, HaveNamesAndHelp) {
    expect_told_apart(engine_stages());
    expect_told_apart(depth_stages());
    expect_told_apart(fill_stages());
}

TEST(Stages, EnginesAreWhatTheirRowsSay) {
    for (const EngineStage& stage : engine_stages()) {
        const auto engine = make_engine(stage.name);
        EXPECT_EQ(engine->name(), stage.name);
        const DepthNeeds needs = engine->needs_depth(Pose{}, Pose{{1, 0, 0}, {1, 0, 0, 0}});
        EXPECT_EQ(needs.source, stage.needs.source) << stage.name;
        EXPECT_EQ(needs.eye, stage.needs.eye) << stage.name;
        EXPECT_FALSE(stage.finds_depth && stage.needs.eye) << stage.name;
        EXPECT_FALSE(engine->needs_depth(Pose{}, Pose{}).any()) << stage.name;
    }
}

TEST(Stages, FillPassesAreWhatTheirRowsSay) {
    std::string all;
    std::set<int> order;
    for (const FillStage& stage : fill_stages()) {
        all += (all.empty() ? "" : ",") + std::string(stage.name);
        EXPECT_EQ(stage.make()->name(), stage.name);
        EXPECT_TRUE(order.insert(stage.left_out).second) << stage.name << ": which goes first?";
        EXPECT_TRUE(!stage.needs_depth || stage.make()->wants_depth()) << stage.name;
        EXPECT_TRUE(!stage.invents || stage.reads.none()) << stage.name;
    }
    const FillChain chain = make_fill_chain(all);
    EXPECT_TRUE(std::ranges::equal(
        chain, fill_stages(), {}, [](const auto& pass) { return pass->name(); }, &FillStage::name));
}

TEST(Stages, OldNamesAreTakenAndAnswered) {
    for (const auto& [old, now] :
         {std::pair{"sphere", "rotation"}, {"lean", "proxy-sphere"}, {"surface", "eye-depth"}}) {
        EXPECT_EQ(make_engine(old)->name(), now);
        EXPECT_EQ(renamed_note(find_engine(old), old, "--method"),
                  "--method " + std::string(old) + " is now called " + now);
        EXPECT_EQ(renamed_note(find_engine(now), now, "--method"), "");
    }
}

TEST(Stages, UnknownNamesAreAnsweredByTheAcceptedOnes) {
    EXPECT_EQ(complaint([] { find_engine("warp", "--method", "auto"); }),
              "--method: expected rotation, proxy-sphere, eye-depth, mesh, splat, mesh-plain or auto, found 'warp'");
    EXPECT_EQ(complaint([] { find_depth("rays"); }),
              "--depth: expected ray, gl, gl-cube, stream or exact, found 'rays'");
    EXPECT_EQ(complaint([] { parse_fills("hidden,telea"); }),
              "--fill: expected none, or a list of hidden, patches, earlier, small, small-wide, geometry, base, "
              "pushpull or spread, found 'telea'");
    EXPECT_NE(complaint([] { find_engine(""); }), "");
    EXPECT_NE(complaint([] { parse_fills("hidden,none"); }), "");
    EXPECT_TRUE(parse_fills("none").empty());
}

TEST(Stages, HelpListsEachOnce) {
    EXPECT_TRUE(described(depth_stages()).starts_with("\nray           cast from the scene\ngl            drawn"))
        << described(depth_stages());
    EXPECT_EQ(described(depth_stages(), true), "") << "the viewer draws its depth itself";
}

}  // namespace
