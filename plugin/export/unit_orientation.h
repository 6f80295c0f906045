#pragma once
/// Orientations as readers of frames take them.
#include <equistream/camera.h>

#include <cmath>

namespace equistream {

/// `q`, which orientation_mismatch has passed, at length 1: what is made of it then only turns. One of that length up
/// to rounding stays to the bit, so that frames are read as they were written.
inline glm::dquat unit_orientation(const glm::dquat& q) {
    constexpr double rounding = 1e-12;
    const double length = glm::length(q);
    return std::abs(length - 1) < rounding ? q : q / length;
}

}  // namespace equistream
