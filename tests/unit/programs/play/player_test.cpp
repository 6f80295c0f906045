/// What play notes of a source.
#include <programs/play/player.h>
#include <tests/support/gapped_stream.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>

namespace equistream::play {
namespace {

using Notes = test::TemporaryFolder;

/// Frames of ordinary video are numbered by their times, and its rate may vary.
TEST_F(Notes, OnlyOfPosedFramesAreNumbersMissing) {
    for (const bool posed : {false, true}) {
        const std::filesystem::path file = folder_ / (posed ? "posed.mkv" : "ordinary.mkv");
        testing::write_gapped_stream(file.string(), posed);
        Settings settings;
        settings.source = file.string();
        settings.method = "rotation";
        settings.size = cli::Size{32, 32};
        settings.out = folder_ / (posed ? "posed" : "ordinary");
        const Report report = play(settings);
        EXPECT_EQ(report.played, 9);
        EXPECT_EQ(std::ranges::count(report.notes, file.string() + ": frames missing in between: 177, the first is 6"),
                  posed ? 1 : 0);
        EXPECT_EQ(
            std::ranges::any_of(
                report.notes, [](const std::string& note) { return note.find("frames missing") != std::string::npos; }),
            posed);
    }
}

/// Eight frames at 30 a second with depth, but for that of some.
void write_stream_without(const std::set<std::int64_t>& lost_depth, const std::string& file) {
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 128, 64}, {TrackRole::depth, 128, 64, DepthCodeId::w10}};
    StreamWriter writer(file, settings);
    for (std::int64_t number = 0; number < 8; ++number) {
        FrameInfo info;
        info.index = number;
        info.time_s = double(number) / 30;
        info.camera = EquirectCamera{128, 64, {}};
        writer.write(TrackRole::main, ByteImage(128, 64, 3, 99).view(), info);
        info.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 0.75, false}, 0};
        if (!lost_depth.contains(number))
            writer.write_depth(TrackRole::depth, FloatImage(128, 64, 1, 2).view(), info);
    }
    writer.finish();
}

class LostDepth : public test::TemporaryFolder {
protected:
    LostDepth() {
        settings_.source = (folder_ / "a.mkv").string();
        settings_.size = cli::Size{32, 32};
        settings_.out = folder_ / "eyes";
    }
    Report play_without(const std::set<std::int64_t>& lost_depth) const {
        write_stream_without(lost_depth, settings_.source);
        return play(settings_);
    }

    Settings settings_;
};

/// As in the middle of a damaged stream, and where one is cut between a picture and its depth.
TEST_F(LostDepth, FramesAreOnlyTurnedAndCounted) {
    settings_.reliability = true;
    const std::set<std::int64_t> lost = {3, 7};
    const Report report = play_without(lost);
    EXPECT_EQ(report.method, "mesh");
    EXPECT_EQ(report.played, 8);
    for (const FrameFigures& frame : report.frames) {
        EXPECT_EQ(frame.lacks_depth, lost.contains(frame.index)) << frame.index;
        EXPECT_EQ(frame.milliseconds[std::size_t(Stage::depth)].empty(), lost.contains(frame.index)) << frame.index;
        EXPECT_TRUE(frame.left.reliability && frame.right.reliability) << frame.index;
    }
    EXPECT_EQ(std::ranges::count(report.notes, "in 2 of 8 frames the depth of " + settings_.source +
                                                   " is missing: method rotation there (the eye only turns)"),
              1);
}

TEST_F(LostDepth, NeitherEndsNorMisleadsTheChoiceByTime) {
    settings_.method = "auto";
    settings_.budget_ms = 1e6;
    const Report report = play_without({1, 4});
    EXPECT_EQ(report.played, 8);
    EXPECT_EQ(report.lacking_depth, 2);
    ASSERT_TRUE(report.choice);
    EXPECT_EQ(report.choice->frame, 0) << "the second would only be turned";
    EXPECT_EQ(report.choice->plan().method, "mesh");
}

TEST_F(LostDepth, IsNoneThatTheMethodTakes) {
    settings_.method = "rotation";
    EXPECT_EQ(play_without({3}).lacking_depth, 0);
}

}  // namespace
}  // namespace equistream::play
