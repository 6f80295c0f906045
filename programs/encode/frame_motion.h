#pragma once
/// What of a rendered frame moves by itself, for its frame data.
#include "sources.h"

#include <plugin/motion/find_moving_regions.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace equistream {

/// Planes that motion is found in, of those that frames as this one have. Throws InputError naming the file and what it
/// lacks.
std::vector<std::string> motion_planes(const std::filesystem::path& file);

/// `frame` is the one of that index in the folder, read with motion_planes. Its neighbours are there or not: of those
/// that are, poses are read.
FoundMotion find_motion(const std::filesystem::path& folder, const Frame& frame, std::int64_t index);

/// Of a whole sequence.
struct MotionTotals {
    std::int64_t frames = 0;       ///< in which something moves
    std::int64_t max_regions = 0;  ///< in a frame
    std::int64_t left_out = 0;     ///< regions that found no room in their frame's data
    std::int64_t bytes = 0;        ///< in frame data, beyond those that say that nothing moves
    /// Over moving pixels, display pixels at the focal length of the bound, in extrapolation_horizon_s.
    double mean_motion_px = 0, mean_error_px = 0, worst_p95_error_px = 0;

    /// Moves what was found into `info`, the smallest regions left out where there is no room.
    void add(const FoundMotion& found, FrameInfo& info);

private:
    double pixels_ = 0;
};

}  // namespace equistream
