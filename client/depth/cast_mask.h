#pragma once
/// Which pixels of a new sphere are to be cast. Internal to RayDepth.
#include <equistream/camera.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace equistream {

/// A ball around a moving object, in the world.
struct MoverBall {
    glm::dvec3 centre_m;
    double radius_m;
};

/// What of a new frame has to be cast, a byte a pixel; rows have spare bytes for whole registers.
class CastMask {
public:
    /// All 0; memory is kept.
    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        stride_ = width + 16;
        bytes_.assign(std::size_t(stride_) * std::size_t(height), 0);
    }
    std::uint8_t* row(int y) { return bytes_.data() + std::ptrdiff_t(y) * stride_; }
    void set_all(std::uint8_t value) { std::fill(bytes_.begin(), bytes_.end(), value); }

    /// Columns from `first` to `last`, round the seam where the picture closes. Several threads may mark one pixel.
    void mark(int y, int first, int last, const EquirectCamera& camera);
    /// All that a ball covers as seen from `pose`, and a pixel around.
    void mark_ball(const MoverBall& ball, const EquirectCamera& camera, const Pose& pose);

    /// The marked pixels of a square of 4 by 4, a bit each, row by row; those beyond the picture are not marked.
    unsigned square(int x, int y) const {
        unsigned bits = 0;
        for (int j = 0; j < std::min(4, height_ - y); ++j) {
            std::uint32_t four;
            std::memcpy(&four, bytes_.data() + std::ptrdiff_t(y + j) * stride_ + x, sizeof four);
            if (four != 0)
                for (int i = 0; i < std::min(4, width_ - x); ++i)
                    bits |= unsigned(four >> 8 * i & 1) << (4 * j + i);
        }
        return bits;
    }

private:
    int width_ = 0, height_ = 0, stride_ = 0;
    std::vector<std::uint8_t> bytes_;
};

}  // namespace equistream
