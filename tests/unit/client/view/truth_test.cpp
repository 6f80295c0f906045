/// True eyes are read by a thread of their own: who asks for one never waits.
#include "frames_folder.h"

#include <equistream/error.h>
#include <equistream/picture.h>

#include <client/view/recorder.h>
#include <client/view/truth.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>

namespace equistream::test {
namespace {

class TrueEyes : public testing::Test {
protected:
    static constexpr double interval_s = 1.0 / 30;

    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("equistream_truth_" + std::to_string(::getpid()));

    std::filesystem::path file(const char* eye, int index) const { return folder / eye / frame_file_name(index); }
    /// Whose brightness is the frame's number, and the right eye's half as much.
    void SetUp() override {
        for (const char* eye : {"left", "right"}) {
            std::filesystem::create_directories(folder / eye);
            for (int index = 0; index < 6; ++index) {
                Frame frame;
                frame.info.index = index;
                frame.info.time_s = index * interval_s;
                frame.info.camera = PerspectiveCamera{32, 16, 1};
                frame.info.head.position_m.x = index;
                frame.planes["colour"] = FloatImage(32, 16, 4, 0.1f * float(index) / (eye[0] == 'l' ? 1 : 2));
                write_exr(file(eye, index), frame);
            }
        }
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    static Truth::Found waited_for(Truth& truth, double time_s, Eye eye) {
        for (int i = 0; i < 20000; ++i, doze())
            if (Truth::Found found = truth.at(time_s, eye); !found.is_coming)
                return found;
        ADD_FAILURE() << "nothing was read within 20 s";
        return {};
    }
};

TEST_F(TrueEyes, AreThoseOfTheTimeAndTheEyeThatAreAskedFor) {
    Truth truth(folder);
    EXPECT_EQ(truth.camera().width, 32);
    for (const int index : {0, 1, 2, 5, 3}) {
        const Truth::Found left = waited_for(truth, (index + 0.3) * interval_s, Eye::left);
        ASSERT_TRUE(left.eye) << left.problem;
        EXPECT_EQ(left.eye->head.position_m.x, index);
        const Truth::Found right = waited_for(truth, index * interval_s, Eye::right);
        ASSERT_TRUE(right.eye) << right.problem;
        EXPECT_EQ(right.eye->rgb.samples()[0]<left.eye->rgb.samples()[0], index> 0);
    }
    const Truth::Found none = waited_for(truth, 6 * interval_s, Eye::left);
    EXPECT_EQ(none.eye, nullptr);
    EXPECT_EQ(none.problem, "");
}

TEST_F(TrueEyes, AreNotWaitedFor) {
    Truth truth(folder);
    for (const int index : {5, 0, 5}) {  // so far apart that none is read ahead of another
        EXPECT_TRUE(truth.at(index * interval_s, Eye::left).is_coming) << index;
        EXPECT_TRUE(waited_for(truth, index * interval_s, Eye::left).eye) << index;
    }
}

TEST_F(TrueEyes, SayWhatCannotBeReadAndGoOn) {
    std::ofstream(file("left", 1)) << "no picture";
    Truth truth(folder);
    EXPECT_TRUE(waited_for(truth, 0, Eye::left).eye);
    const Truth::Found broken = waited_for(truth, interval_s, Eye::left);
    EXPECT_EQ(broken.eye, nullptr);
    EXPECT_NE(broken.problem.find("frame.0001.exr"), std::string::npos) << broken.problem;
    EXPECT_TRUE(waited_for(truth, interval_s, Eye::right).eye);
    EXPECT_TRUE(waited_for(truth, 2 * interval_s, Eye::left).eye);
    std::ofstream(file("left", 0)) << "no picture";
    EXPECT_THROW(Truth again(folder), InputError);
}

}  // namespace

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

namespace {

using FrameLoaders = FramesFolder;

TEST_F(FrameLoaders, GivesEveryFrameInOrderAndThenItsEnd) {
    FrameLoader loader(folder.string(), {});
    EXPECT_EQ(loader.first().index, 0);
    EXPECT_FALSE(loader.is_live());
    for (int index = 0; index < frame_count; ++index) {
        const SharedFrame frame = waited_for(loader);
        ASSERT_NE(frame, nullptr);
        EXPECT_EQ(frame->main.info.index, index);
    }
    EXPECT_EQ(waited_for(loader), nullptr);
    EXPECT_TRUE(loader.state().ended);
    EXPECT_EQ(loader.truncation(), "");
}

/// None is thinned out of the ring, however fast reading is.
TEST_F(FrameLoaders, ReadsAFewAheadAndWaits) {
    std::atomic<int> asked = 0;
    FrameLoader loader(folder.string(), {.left_out = [&] { return ++asked, TrackRoles{}; }});
    for (int i = 0; i < 100; ++i)
        doze();
    EXPECT_LE(asked, 4);
    for (int index = 0; index < frame_count; ++index)
        EXPECT_EQ(waited_for(loader)->main.info.index, index);
    EXPECT_EQ(loader.state().reel->counts().thinned, 0);
}

/// Else so many frames a second would be shown too slowly: a refresh takes no more of them than were read.
TEST_F(FrameLoaders, ReadsMoreAheadWhereFramesAreShort) {
    constexpr std::int64_t ahead = 50, count = ahead + 10;  // of 1 ms: three refreshes of 60 a second
    write_frames(range(0, count - 1), 1000);
    FrameLoader loader(folder.string(), {});
    for (int i = 0; i < 20000 && loader.figures().frames < ahead; ++i)
        doze();
    for (int i = 0; i < 50; ++i)
        doze();
    EXPECT_EQ(loader.figures().frames, ahead);
    for (std::int64_t number = 0; number < count; ++number)
        EXPECT_EQ(waited_for(loader)->main.info.index, number);
    EXPECT_EQ(loader.state().reel->counts().thinned, 0);
}

TEST_F(FrameLoaders, JumpsToAFrameFromTheMiddleAndFromTheEnd) {
    FrameLoader loader(folder.string(), {});
    for (int round = 0; round < 3; ++round) {
        loader.seek(9);
        for (int index = 9; index < frame_count; ++index)
            EXPECT_EQ(waited_for(loader)->main.info.index, index) << round;
        EXPECT_EQ(waited_for(loader), nullptr);
        loader.seek(2);
        EXPECT_FALSE(loader.state().ended);
        EXPECT_EQ(waited_for(loader)->main.info.index, 2) << round;
    }
    for (int i = 0; i < 50; ++i)  // faster than anything can be read
        loader.seek(i % frame_count);
    EXPECT_EQ(waited_for(loader)->main.info.index, 49 % frame_count);
}

TEST_F(FrameLoaders, BehindTheEndThereIsNothingAndBackIsPossible) {
    FrameLoader loader(folder.string(), {});
    loader.seek(frame_count + 5);
    EXPECT_EQ(waited_for(loader), nullptr);
    EXPECT_TRUE(loader.state().ended);
    loader.seek(frame_count - 1);
    EXPECT_EQ(waited_for(loader)->main.info.index, frame_count - 1);
}

/// A frame in use stays whole when its loader is gone.
TEST_F(FrameLoaders, FramesOutliveIt) {
    SharedFrame frame;
    {
        FrameLoader loader(folder.string(), {});
        frame = waited_for(loader);
    }
    EXPECT_EQ(frame->main.rgb.width(), 32);
}

TEST_F(FrameLoaders, WhatCannotBeReadIsSaid) {
    EXPECT_THROW(FrameLoader("/nowhere/walk.mkv", {}), InputError);
    std::filesystem::create_directories(folder / "empty");
    EXPECT_THROW(FrameLoader((folder / "empty").string(), {}), InputError);
    std::ofstream(folder / "centre" / frame_file_name(1)) << "no picture";
    FrameLoader loader(folder.string(), {});
    EXPECT_EQ(waited_for(loader)->main.info.index, 0);
    EXPECT_THROW(waited_for(loader), std::exception);
}

}  // namespace
}  // namespace equistream::test
