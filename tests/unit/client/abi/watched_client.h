#pragma once
/// Streams that are not as they should be, and a client that goes through them by refreshes of a made-up clock.
#include <tests/unit/plugin/stream/depth_stream.h>

#include <equistream/client.hpp>
#include <equistream/rec709.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace equistream::test {

/// Pictures of a stream, by index.
struct Faults {
    std::set<std::int64_t> other_size{};  ///< tagged with twice their width and height
    std::set<std::int64_t> lost_depth{};
    bool has_motion = false;  ///< something moves by itself
};

inline void set_in_motion(FrameInfo& info) {
    MovingRegion& ball = info.moving.emplace_back();
    ball.motion.twist.velocity_m_s = {0.1, 0, 0};
    ball.near_m = 0.7f;
    ball.far_m = 0.8f;
    ball.runs = {{48, 50, 70}};
}

inline void write_with(const std::string& file, const Faults& faults) {
    StreamWriter writer(file, settings_of(Codec::h264, DepthCodeId::w10));
    for (std::int64_t index = 0; index < pictures; ++index) {
        FrameInfo colour = info_of(index), depth = info_of(index, DepthCodeId::w10);
        if (faults.other_size.contains(index))
            colour.camera = depth.camera = EquirectCamera{2 * width, 2 * height, {}};
        if (faults.has_motion)
            set_in_motion(colour);
        writer.write(TrackRole::main, synthetic::picture(width, height, index).view(), colour);
        if (!faults.lost_depth.contains(index))
            writer.write_depth(TrackRole::depth, depth_of(index).view(), depth);
    }
    writer.finish();
}

/// One frame of PQ, all of the same grey.
inline void write_hdr(const std::string& file, float grey_pq) {
    const FloatImage grey(128, 64, 3, grey_pq);
    StreamSettings hdr;
    hdr.transfer = Transfer::pq;
    hdr.preset = "ultrafast";
    hdr.tracks = {{TrackRole::main, grey.width(), grey.height()}};
    StreamWriter writer(file, hdr);
    writer.write_pq(TrackRole::main, grey.view(), synthetic::info(grey.width(), grey.height(), 0));
    writer.finish();
}

/// One refresh.
struct Look {
    es_client_state state;
    std::string problem;  ///< empty: what was due is shown
};

/// Reading takes the time that it takes, while the clock stands still.
class WatchedClient {
public:
    explicit WatchedClient(const es_client_settings& settings)
        : client(settings), request(client.request(48, 36, pi / 2)) {}

    Look look(double elapsed_s = 1.0 / 60) {
        request.display_s += elapsed_s;
        try {
            return {client.render(request, eyes), ""};
        } catch (const ClientError& error) {
            EXPECT_FALSE(error.is_input) << error.what();
            EXPECT_TRUE(error.shown) << error.what();
            return {error.shown.value_or(es_client_state{}), error.what()};
        }
    }
    std::vector<Look> watch(const std::function<bool(const Look&)>& until) {
        std::vector<Look> seen;
        for (int i = 0; i < 5000; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(1))) {
            seen.push_back(look());
            if (until(seen.back()))
                return seen;
        }
        ADD_FAILURE() << "nothing came of it";
        return seen;
    }
    std::vector<Look> watch_all() {
        return watch([](const Look& look) { return look.state.is_over != 0; });
    }

    /// Low in the picture, where the source has seen it from wherever it was.
    bool sees_floor() const {
        const std::vector<std::uint8_t>& origin = eyes[1].origin;
        return !origin.empty() && origin[origin.size() * 3 / 4] == ES_ORIGIN_SOURCE;
    }

    Client client;
    es_client_request request;
    ClientPicture eyes[2];
};

/// A stop less of exposure halves the light that is shown.
inline void expect_exposure_by_stops(es_client_settings settings) {
    const auto light_at = [&](double stops) {
        settings.exposure_stops = stops;
        WatchedClient watched(settings);
        EXPECT_EQ(watched.look().problem, "");
        const std::vector<std::uint8_t>& rgba = watched.eyes[1].rgba;
        return double(srgb_to_linear(float(rgba[rgba.size() / 8 * 4 + 1]) / 255));
    };
    const double light = light_at(0);
    EXPECT_GT(light, 0.3);
    EXPECT_LT(light, 0.6);
    EXPECT_NEAR(light_at(-1) / light, 0.5, 0.03);
}

inline std::vector<std::int64_t> frames_of(const std::vector<Look>& seen) {
    std::vector<std::int64_t> frames;
    for (const Look& look : seen)
        if (frames.empty() || frames.back() != look.state.frame)
            frames.push_back(look.state.frame);
    return frames;
}

/// The frame before is shown once more, and the client goes on by itself.
inline void expect_all_but_one_frame(WatchedClient& watched, std::int64_t wrong, const std::string& words) {
    int problems = 0;
    const std::vector<Look> seen = watched.watch([&](const Look& look) {
        EXPECT_FALSE(look.state.is_paused);
        if (look.problem.empty())
            return look.state.is_over != 0;
        ++problems;
        EXPECT_NE(look.problem.find(words), std::string::npos) << look.problem;
        EXPECT_EQ(look.state.frame, wrong - 1);
        EXPECT_FALSE(look.state.is_new);
        EXPECT_EQ(watched.eyes[1].width, watched.request.width);
        EXPECT_TRUE(watched.sees_floor());
        return look.state.is_over != 0;
    });
    EXPECT_EQ(problems, 1);
    std::vector<std::int64_t> expected;
    for (std::int64_t index = 0; index < pictures; ++index)
        if (index != wrong)
            expected.push_back(index);
    EXPECT_EQ(frames_of(seen), expected);
    EXPECT_EQ(watched.client.statistics().frames_shown, pictures - 1);
}

}  // namespace equistream::test
