#pragma once
/// A folder of rendered frames with depth, for clients to open: a red ball before a wall.
#include <tests/unit/client/fill_scene.h>

#include <equistream/client.hpp>
#include <equistream/rec709.h>
#include <equistream/sequence.h>

#include <unistd.h>

#include <filesystem>
#include <string>

namespace equistream::test {

class ClientFolder : public testing::Test {
protected:
    static constexpr int frame_count = 3, columns = 512;

    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("equistream_client_" + std::to_string(::getpid()));

    void SetUp() override {
        std::filesystem::create_directories(folder / "centre");
        write_frame(0, {});
        for (int index = 1; index < frame_count; ++index)
            write_again(index);
    }
    static FloatImage linear_colour(const ByteImage& rgb) {
        FloatImage colour(rgb.width(), rgb.height(), 4);
        for (int y = 0; y < rgb.height(); ++y)
            for (int x = 0; x < rgb.width(); ++x)
                for (int c = 0; c < 4; ++c)
                    colour.pixel(x, y)[c] = c == 3 ? 1.0f : srgb_to_linear(float(rgb.pixel(x, y)[c]) / 255);
        return colour;
    }
    /// As seen from `pose`.
    void write_frame(int index, const Pose& pose) {
        const EquirectCamera camera{columns, columns / 2, {}};
        const Rendered seen = render(ball_and_wall, red_and_smooth, camera, pose);
        frame_.info.camera = camera;
        frame_.info.camera_pose = frame_.info.head = pose;
        frame_.info.frames_per_second = 30;
        frame_.info.ipd_m = 0.063;
        frame_.info.scene = "room";
        frame_.planes["colour"] = linear_colour(seen.rgb);
        frame_.planes["depth"] = seen.depth_m;
        write_again(index);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    es_client_settings settings(es_backend backend = ES_BACKEND_CPU) {
        es_client_settings paused = client_settings(source_.c_str(), backend);
        paused.paused = 1;
        return paused;
    }

private:
    void write_again(int index) {
        frame_.info.index = index;
        frame_.info.time_s = index / 30.0;
        write_exr(folder / "centre" / frame_file_name(index), frame_);
    }

    const std::string source_ = folder.string();
    Frame frame_;
};

}  // namespace equistream::test
