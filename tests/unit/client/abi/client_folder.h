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
        const EquirectCamera camera{columns, columns / 2, {}};
        const Rendered seen = render(ball_and_wall, red_and_smooth, camera, {});
        for (int index = 0; index < frame_count; ++index) {
            Frame frame;
            frame.info.index = index;
            frame.info.time_s = index / 30.0;
            frame.info.frames_per_second = 30;
            frame.info.camera = camera;
            frame.info.ipd_m = 0.063;
            frame.info.scene = "room";
            FloatImage colour(camera.width, camera.height, 4);
            for (int y = 0; y < camera.height; ++y)
                for (int x = 0; x < camera.width; ++x)
                    for (int c = 0; c < 4; ++c)
                        colour.pixel(x, y)[c] = c == 3 ? 1.0f : srgb_to_linear(float(seen.rgb.pixel(x, y)[c]) / 255);
            frame.planes["colour"] = std::move(colour);
            frame.planes["depth"] = seen.depth_m;
            write_exr(folder / "centre" / frame_file_name(index), frame);
        }
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    es_client_settings settings(es_backend backend = ES_BACKEND_CPU) {
        es_client_settings paused = client_settings(source_.c_str(), backend);
        paused.paused = 1;
        return paused;
    }

private:
    const std::string source_ = folder.string();
};

}  // namespace equistream::test
