#include <client/view/recorder.h>

#include <equistream/picture.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

class Recordings : public testing::Test {
protected:
    fs::path folder = fs::temp_directory_path() / ("equistream_recordings_" + std::to_string(::getpid()));
    ByteImage picture = ByteImage(4, 3, 3, 77);
    void TearDown() override { fs::remove_all(folder); }
};

TEST_F(Recordings, NamesCountUpAndNothingIsWrittenOver) {
    for (int i = 0; i < 2; ++i) {
        Recorder recorder(folder);
        recorder.keep_picture(picture.view());
    }
    EXPECT_TRUE(fs::exists(folder / "view.0001.png"));
    EXPECT_TRUE(fs::exists(folder / "view.0002.png"));
    EXPECT_FALSE(fs::exists(folder / "view.0003.png"));
}

TEST_F(Recordings, PicturesAreNumberedWhileItRecords) {
    Recorder recorder(folder);
    recorder.add_view(picture.view());
    recorder.start_or_stop_view();
    for (int i = 0; i < 3; ++i)
        recorder.add_view(picture.view());
    EXPECT_EQ(recorder.start_or_stop_view(), "recorded 3 pictures into " + (folder / "recording.0001").string());
    recorder.add_view(picture.view());
    EXPECT_TRUE(fs::exists(folder / "recording.0001" / "frame.0002.png"));
    EXPECT_FALSE(fs::exists(folder / "recording.0001" / "frame.0003.png"));
}

TEST_F(Recordings, PathsAreInTheSourcesTimeAndLeaveStandstillsOut) {
    Recorder recorder(folder);
    recorder.add_head(1, {});
    recorder.start_or_stop_head();
    for (const double time_s : {5.0, 5.5, 5.5, 6.25})
        recorder.add_head(time_s, {{time_s, 0, 0}, {1, 0, 0, 0}});
    recorder.start_or_stop_head();
    const PosePath path = read_path_csv(folder / "head.0001.csv");
    ASSERT_EQ(path.keys().size(), 3u);
    EXPECT_EQ(path.keys()[0].time_s, 5);
    EXPECT_EQ(path.keys()[2].time_s, 6.25);
    EXPECT_EQ(path.keys()[2].pose.position_m.x, 6.25);
}

/// A viewer that is closed while it records has lost nothing.
TEST_F(Recordings, AnUnfinishedPathIsKept) {
    {
        Recorder recorder(folder);
        recorder.start_or_stop_head();
        recorder.add_head(0, {});
    }
    EXPECT_EQ(read_path_csv(folder / "head.0001.csv").keys().size(), 1u);
}

TEST_F(Recordings, AFolderThatCannotBeMadeIsNamed) {
    fs::create_directories(folder);
    write_picture(folder / "file.png", picture.view());
    Recorder recorder(folder / "file.png" / "below");
    EXPECT_THROW(recorder.keep_picture(picture.view()), std::exception);
    EXPECT_THROW(recorder.start_or_stop_view(), std::exception);
    EXPECT_FALSE(recorder.records_view());
}

}  // namespace
}  // namespace equistream::test
