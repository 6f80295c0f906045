#pragma once
/// A depth sphere somewhere in the head box, and what of it shows a given surface point.
#include <equistream/depth_agreement.h>
#include <equistream/patches.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

/// A point of a surface as a training eye sees it, from the main sphere's centre.
struct SurfacePoint {
    glm::dvec3 position_m;
    /// The surface's plane is {Y : plane . (Y - eye) = 1}; 0 at infinity.
    glm::dvec3 plane;
    glm::dvec3 eye_m;
};

/// The four samples around the place where a point falls, and how much of the bilinear weight shows its surface.
struct SeenTaps {
    std::array<int, 4> x{}, y{};
    std::array<float, 4> weight{};  ///< 0 where the sample shows something else

    float total() const { return weight[0] + weight[1] + weight[2] + weight[3]; }
};

/// Below this share of the four samples' weight the client's look-up takes a pixel for a gap.
inline constexpr float min_seen_weight = 0.1f;

class DepthSphere {
public:
    DepthSphere(const EquirectCamera& camera, const glm::dvec3& offset_m);

    const EquirectCamera& camera() const { return camera_; }
    const glm::dvec3& offset_m() const { return offset_m_; }
    FloatImage& depth_m() { return depth_m_; }
    const FloatImage& depth_m() const { return depth_m_; }

    /// Unit direction of a pixel's centre; columns go round.
    glm::dvec3 direction(int x, int y) const;
    /// The point that a pixel shows, without its plane.
    SurfacePoint point(int x, int y) const;
    /// The surface's plane there, laid through the neighbours that are nearer in depth.
    glm::dvec3 plane(int x, int y) const;

    /// Whether and where this sphere shows the point, by the client's rule: depths that agree under the bound, or that
    /// lie between the point's own depth and what its plane predicts. `agreement` is for this eye and this sphere.
    SeenTaps seen(const SurfacePoint& point, const DepthAgreement& agreement) const;

private:
    int wrapped_column(int x) const;

    EquirectCamera camera_;
    glm::dvec3 offset_m_;
    FloatImage depth_m_;
    std::vector<glm::dvec2> longitude_, latitude_;  // sine and cosine by column, by row
};

// What training eyes see and the sphere's centre does not, and which blocks of auxiliary spheres show it.

/// Which block of which auxiliary sphere: (sphere * block rows + row) * block columns + column.
using BlockId = std::uint32_t;

/// Gap samples and, for each, the blocks that cover it.
struct GapSamples {
    std::vector<float> weight;         ///< solid angle in its eye
    std::vector<std::uint32_t> first;  ///< into `blocks`; one more than there are samples
    std::vector<BlockId> blocks;
};

struct GapRule {
    double box_radius_m = 0;
    double tolerance_rad = 0;
    int block_side = 16;
    double weight = 1;  ///< how much the eye counts
    int stride = 2;     ///< every so many columns and rows of the eye
};

/// Appends the gap samples of one training eye. All spheres have the same camera.
void append_gap_samples(const DepthSphere& eye, const DepthSphere& centre, std::span<const DepthSphere> auxiliary,
                        const GapRule& rule, GapSamples& samples);

}  // namespace equistream
