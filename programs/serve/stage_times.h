#pragma once
/// How long the stages of a live sphere take, from the pose that it is made for to its bytes.
#include <array>
#include <cstddef>
#include <deque>

#include <nlohmann/json_fwd.hpp>

namespace equistream::serve {

enum class LiveStage {
    pose,    ///< from a pose's coming until a sphere is ordered for it; only of poses that are new
    render,  ///< until the renderer has the picture
    hand_over,
    wait,  ///< until the encoder is free
    encode,
    all,  ///< from the pose's coming, or the order where none is new, until the bytes can be sent
};
inline constexpr std::array<const char*, 6> live_stage_names = {"pose", "render", "hand_over", "wait", "encode", "all"};

/// Of the latest spheres: a server may run for weeks.
class StageTimes {
public:
    static constexpr std::size_t kept = 1000;

    void add(LiveStage stage, double seconds);
    /// By stage, of those that have any: p50 and p99 (nearest ranks), the mean, and how many, in milliseconds.
    nlohmann::ordered_json json() const;

private:
    std::array<std::deque<double>, live_stage_names.size()> seconds_;
};

}  // namespace equistream::serve
