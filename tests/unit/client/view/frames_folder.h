#pragma once
/// A folder of small frames, 30 a second, and who takes them from a loader one by one.
#include <client/playback/frame_loader.h>

#include <equistream/sequence.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>

namespace equistream::test {

inline void doze() {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

class FramesFolder : public testing::Test {
protected:
    static constexpr int frame_count = 12;
    static constexpr double interval_s = 1.0 / 30;

    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("equistream_loader_" + std::to_string(::getpid()));

    void SetUp() override {
        std::filesystem::create_directories(folder / "centre");
        for (int index = 0; index < frame_count; ++index) {
            Frame frame;
            frame.info.index = index;
            frame.info.time_s = index * interval_s;
            frame.info.camera = EquirectCamera{32, 16, {}};
            frame.planes["colour"] = FloatImage(32, 16, 4, 0.1f);
            write_exr(folder / "centre" / frame_file_name(index), frame);
        }
    }
    void TearDown() override { std::filesystem::remove_all(folder); }
};

/// The next frame, whenever the reading thread brings it; null at the end.
inline SharedFrame waited_for(FrameLoader& loader) {
    for (int i = 0; i < 20000; ++i, doze()) {
        const LoaderState state = loader.state();
        if (const auto stamp = state.reel->next_arrival()) {
            const SharedFrame frame = state.reel->payload(state.reel->show(stamp->frame_time_s)[0]).frame;
            EXPECT_EQ(frame->main.info.index, stamp->number);
            loader.passed(*state.reel, 1);
            return frame;
        }
        if (state.ended)
            return nullptr;
        if (state.failed)
            loader.rethrow();
    }
    ADD_FAILURE() << "no frame within 20 s";
    return nullptr;
}

}  // namespace equistream::test
