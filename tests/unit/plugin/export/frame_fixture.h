#pragma once
/// A frame with every plane filled with values that are exact in their EXR type, and a folder of its own per test.
#include <equistream/aov.h>
#include <equistream/frame.h>
#include <equistream/sequence.h>

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <unistd.h>

namespace equistream::testing {

class FolderTest : public ::testing::Test {
protected:
    void SetUp() override {
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        folder = std::filesystem::temp_directory_path() /
                 ("equistream-" + std::to_string(getpid()) + "-" + info->test_suite_name() + "-" + info->name());
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    std::filesystem::path folder;
};

/// A deterministic value that a half holds exactly.
inline float half_value(int x, int y, int c) {
    return static_cast<float>((x * 7 + y * 13 + c * 29) % 2048) / 64.0f;
}

inline FrameInfo test_info(int width, int height) {
    FrameInfo info;
    info.index = 41;
    info.time_s = 41 / 29.97;
    info.frames_per_second = 30000.0 / 1001;
    info.camera = EquirectCamera{width, height, {}};
    info.camera_pose = {{0.1, -2.0 / 3, 1e9 / 7}, glm::dquat(1, 0, 0, 0)};
    info.head = {{0.2, 1.0 / 3, -5}, glm::normalize(glm::dquat(0.3, 0.1, -0.9, 0.2))};
    info.eye = Eye::left;
    info.ipd_m = 0.0631;
    info.lock = AxisLock::path;
    info.head_radius_m = 0.25;
    info.exposure = 1.7;
    info.seed = 0xfedcba9876543210ull;
    info.samples_per_pixel = 1000;
    info.scene = "sponza \"quoted\"";
    info.host = "toy 1.2";
    info.geometry_fingerprint = "0123456789abcdef";
    return info;
}

inline Frame test_frame(int width, int height) {
    Frame frame;
    frame.info = test_info(width, height);
    for (const AovInfo& aov : aov_catalogue()) {
        const int channels = static_cast<int>(aov.channels.size());
        FloatImage real(width, height, channels);
        IdImage ids(width, height, channels);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < channels; ++c) {
                    const float half = half_value(x, y, c);
                    real.pixel(x, y)[c] = aov.type == SampleType::half ? half : std::sin(half * 1.1f) / 3.0f;
                    ids.pixel(x, y)[c] = static_cast<std::uint32_t>(x * 2654435761u + y * 40503u + c);
                }
        if (aov.type == SampleType::id)
            frame.ids[std::string(aov.name)] = ids;
        else
            frame.planes[std::string(aov.name)] = real;
    }
    frame.planes["depth"].pixel(width / 2, height / 2)[0] = std::numeric_limits<float>::infinity();
    return frame;
}

inline std::string file_bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

inline void put_bytes(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace equistream::testing
