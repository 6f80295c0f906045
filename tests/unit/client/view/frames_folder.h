#pragma once
/// A folder of small frames, 30 a second, and who takes them from a loader one by one.
#include <client/playback/frame_loader.h>

#include <equistream/sequence.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <thread>
#include <vector>

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

    void SetUp() override { write_frames(range(0, frame_count - 1), 30); }
    void TearDown() override { std::filesystem::remove_all(folder); }

    /// In place of what is there.
    void write_frames(const std::vector<std::int64_t>& numbers, double frames_per_second) const {
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder / "centre");
        for (const std::int64_t number : numbers) {
            Frame frame;
            frame.info.index = number;
            frame.info.frames_per_second = frames_per_second;
            frame.info.time_s = double(number) / frames_per_second;
            frame.info.camera = EquirectCamera{32, 16, {}};
            frame.planes["colour"] = FloatImage(32, 16, 4, 0.1f);
            write_exr(folder / "centre" / frame_file_name(number), frame);
        }
    }
    static std::vector<std::int64_t> range(std::int64_t first, std::int64_t last) {
        std::vector<std::int64_t> all(std::size_t(last - first + 1));
        std::iota(all.begin(), all.end(), first);
        return all;
    }
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
