#pragma once
/// The values that the panel shows, in words. Pure functions, but for how much memory there is.
#include "face/content.h"
#include "watched_source.h"

#include <client/playback/frame_loader.h>
#include <client/playback/playback.h>
#include <client/view/gl/pixel_probe.h>

#include <cstddef>
#include <string>
#include <vector>

namespace equistream {

/// What is shown, and where it comes from. `name` is without a secret.
std::vector<Fact> source_facts(const std::string& name, const WatchedSource& source, const ReceivedFrame& frame);

struct MethodState {
    std::string engine;        ///< that eyes are made by
    bool by_geometry = false;  ///< of the scene's
    bool has_depth = false;    ///< eyes that move see parallax
    bool is_extrapolated = false;
};
std::vector<Fact> method_facts(const MethodState& state, const ReceivedFrame& frame);

struct NetworkState {
    double bits_per_second = 0;
    bool is_followed = false;  ///< the server renders for this head
    std::string lateness;      ///< empty: frames come in time
};
/// Of files only what their frames were; of live sources all.
std::vector<Fact> network_facts(const Playback& playback, const LoaderFigures& figures, const NetworkState& state);

struct SpeedState {
    double refreshes_per_second = 0, frames_per_second = 0, latency_s = 0, decode_ms = 0;
    std::size_t gpu_bytes = 0, mapped_bytes = 0;
};
std::vector<Fact> speed_facts(const SpeedState& state);

/// What is under the pointer: of an eye that looks as `camera` and `eye` say into a frame.
std::vector<Fact> mouse_facts(const gl::PixelValues& values, const PerspectiveCamera& camera, const Pose& eye,
                              const ReceivedFrame& frame);

/// Of this process, in memory now.
std::size_t resident_bytes();

}  // namespace equistream
