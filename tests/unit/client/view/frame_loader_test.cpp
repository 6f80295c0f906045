#include "frames_folder.h"

#include <equistream/error.h>

#include <atomic>
#include <fstream>

namespace equistream::test {
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
