#include <view/frame_loader.h>

#include <equistream/error.h>
#include <equistream/sequence.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

constexpr int frame_count = 12;

class FrameLoaders : public testing::Test {
protected:
    fs::path folder = fs::temp_directory_path() / ("equistream_loader_" + std::to_string(::getpid()));
    void SetUp() override {
        fs::create_directories(folder / "centre");
        for (int index = 0; index < frame_count; ++index) {
            Frame frame;
            frame.info.index = index;
            frame.info.time_s = index / 30.0;
            frame.info.camera = EquirectCamera{32, 16, {}};
            frame.planes["colour"] = FloatImage(32, 16, 4, 0.1f);
            write_exr(folder / "centre" / frame_file_name(index), frame);
        }
    }
    void TearDown() override { fs::remove_all(folder); }

    /// What the reading thread brings, whenever that is.
    static SharedFrame waited_for(FrameLoader& loader) {
        for (int i = 0; i < 20000; ++i) {
            if (SharedFrame frame = loader.next())
                return frame;
            if (loader.at_end())
                return nullptr;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        ADD_FAILURE() << "no frame within 20 s";
        return nullptr;
    }
};

TEST_F(FrameLoaders, GivesEveryFrameInOrderAndThenItsEnd) {
    FrameLoader loader(folder.string(), {});
    EXPECT_EQ(loader.first().index, 0);
    for (int index = 0; index < frame_count; ++index) {
        const SharedFrame frame = waited_for(loader);
        ASSERT_NE(frame, nullptr);
        EXPECT_EQ(frame->main.info.index, index);
    }
    EXPECT_EQ(waited_for(loader), nullptr);
    EXPECT_TRUE(loader.at_end());
    EXPECT_EQ(loader.fraction_done(), 1);
    EXPECT_EQ(loader.truncation(), "");
}

TEST_F(FrameLoaders, WhatIsDueDropsWhatCameBefore) {
    FrameLoader loader(folder.string(), {});
    EXPECT_EQ(loader.due(-1), nullptr);
    SharedFrame last;
    std::int64_t before = -1;
    while (!loader.at_end()) {
        if (const SharedFrame frame = loader.due(6.5 / 30)) {
            EXPECT_GT(frame->main.info.index, before);
            before = frame->main.info.index;
            last = frame;
        }
        if (before == 6)
            break;
    }
    ASSERT_NE(last, nullptr);
    EXPECT_EQ(last->main.info.index, 6);
    EXPECT_EQ(loader.due(6.9 / 30), nullptr);
    EXPECT_EQ(waited_for(loader)->main.info.index, 7);
}

TEST_F(FrameLoaders, JumpsToAFrameFromTheMiddleAndFromTheEnd) {
    FrameLoader loader(folder.string(), {});
    for (int round = 0; round < 3; ++round) {
        loader.seek(9);
        for (int index = 9; index < frame_count; ++index)
            EXPECT_EQ(waited_for(loader)->main.info.index, index) << round;
        EXPECT_EQ(waited_for(loader), nullptr);
        loader.seek(2);
        EXPECT_FALSE(loader.at_end());
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
    EXPECT_TRUE(loader.at_end());
    loader.seek(frame_count - 1);
    EXPECT_EQ(waited_for(loader)->main.info.index, frame_count - 1);
}

/// A frame in use stays whole when its loader is gone.
TEST_F(FrameLoaders, GapsAreWhatTheSourceLeavesOutAndNotWhatIsJumped) {
    {
        FrameLoader loader(folder.string(), {});
        EXPECT_EQ(waited_for(loader)->main.info.index, 0);
        loader.seek(7);
        EXPECT_EQ(waited_for(loader)->main.info.index, 7);
        EXPECT_EQ(waited_for(loader)->main.info.index, 8);
        EXPECT_FALSE(loader.has_gaps());
    }
    fs::remove(folder / "centre" / frame_file_name(5));
    FrameLoader loader(folder.string(), {});
    while (waited_for(loader)) {
    }
    EXPECT_TRUE(loader.has_gaps());
}

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
    fs::create_directories(folder / "empty");
    EXPECT_THROW(FrameLoader((folder / "empty").string(), {}), InputError);
    std::ofstream(folder / "centre" / frame_file_name(1)) << "no picture";
    FrameLoader loader(folder.string(), {});
    EXPECT_EQ(waited_for(loader)->main.info.index, 0);
    EXPECT_THROW(waited_for(loader), std::exception);
}

}  // namespace
}  // namespace equistream::test
