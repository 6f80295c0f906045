/// What play notes of a source.
#include <programs/play/player.h>
#include <tests/support/gapped_stream.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
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

}  // namespace
}  // namespace equistream::play
