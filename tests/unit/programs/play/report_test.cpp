#include <programs/play/report.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>

namespace equistream::play {
namespace {

/// A live stream may be played for days: figures of its frames stay as large as after two minutes.
TEST(Report, LongPlaysKeepTheLatestFrames) {
    Report report;
    const auto played = std::int64_t(Report::kept_frames) + 100;
    for (std::int64_t index = 0; index < played; ++index) {
        FrameFigures frame;
        frame.index = index;
        frame.outside_head_box = index < 3;
        frame.lacks_depth = index < 2;
        frame.milliseconds[0] = {index < 100 ? 1000.0 : 1.0};
        report.add(std::move(frame));
    }
    const nlohmann::ordered_json json = report.json();
    EXPECT_EQ(json["played"], played);
    ASSERT_EQ(json["frames"].size(), Report::kept_frames);
    EXPECT_EQ(json["frames"].front()["index"], 100);
    EXPECT_EQ(json["frames"].back()["index"], played - 1);
    EXPECT_EQ(json["milliseconds"].front()["p99"], 1.0);
    EXPECT_EQ(report.outside_head_box, 3);
    EXPECT_EQ(report.lacking_depth, 2);
    EXPECT_NE(report.table().find("times and gaps: the latest 1000 frames only"), std::string::npos);
}

/// 90 Hz for an hour would be a gigabyte of JSON.
TEST(Report, LongPlaysSayWhatWasSeenOfTheLatestRefreshes) {
    Report report;
    report.viewing.emplace();
    const auto played = std::int64_t(Report::kept_frames) + 100;
    for (std::int64_t number = 0; number < played; ++number)
        report.viewing->refreshes.emplace_back().number = number;
    report.viewing->report = report_viewing(report.viewing->refreshes, 90);
    const nlohmann::ordered_json viewing = report.json()["viewing"];
    EXPECT_EQ(viewing["refreshes"], played) << "sums are of all";
    ASSERT_EQ(viewing["each"].size(), Report::kept_frames);
    EXPECT_EQ(viewing["each"].front()["number"], 100);
    EXPECT_EQ(viewing["each"].back()["number"], played - 1);
}

TEST(Report, ShortPlaysKeepAll) {
    Report report;
    report.add({});
    EXPECT_EQ(report.json()["played"], 1);
    EXPECT_EQ(report.json()["frames"].size(), 1u);
    EXPECT_EQ(report.table().find("latest"), std::string::npos);
}

}  // namespace
}  // namespace equistream::play
