#pragma once
/// A received picture as it is some time after it was taken: its moving regions (equistream/object_motion.h)
/// extrapolated by their motion, nearest first, before and behind what rests as depth says. A forward pass finds which
/// pixels they come to and how far away they are there, a backward one looks up each of these pixels in the region it
/// came from: outlines are the region's own, and its colours are resampled once. What they uncover shows no surface
/// (depth is NaN), so that engines make a gap of it and the fill chain fills it.
#include <equistream/frame.h>
#include <equistream/object_motion.h>

#include <client/receive/receive.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace equistream {

struct ExtrapolatedPicture {
    ReceivedPicture picture;  ///< rgb always; info is that of the picture it comes from; depth_m empty
    FloatImage depth_m;       ///< of the whole picture
    std::int64_t moved_pixels = 0, uncovered_pixels = 0;
};

/// Whether extrapolating changes anything at all.
bool can_extrapolate(const ReceivedPicture& picture, double seconds);

/// Keeps memory from picture to picture. One thread at a time.
class PictureExtrapolator {
public:
    /// `depth_m` has the picture's size. `extrapolated` keeps its memory from the time before.
    void extrapolate(const ReceivedPicture& picture, const FloatImage& depth_m, double seconds,
                     ExtrapolatedPicture& extrapolated);

private:
    struct Candidate {
        float distance_m;
        int region;
    };
    std::vector<int> region_;            ///< of each pixel before, -1: of none
    std::vector<Candidate> candidates_;  ///< of each pixel afterwards
    std::vector<std::size_t> reached_;   ///< that have a candidate
};

// One moving region on its way in the picture that shows it: where its pixels come to, and where what a pixel shows
// afterwards was.

/// Rows that one pixel may come to cover, each way: what comes nearer by more is no longer seen well anyway.
inline constexpr double max_half_height = 16;
/// What goes beyond is not seen.
inline constexpr double max_extrapolated_m = 1e9;

class MovedRegion {
public:
    MovedRegion(const MovingRegion& region, const FrameInfo& info, double seconds)
        : region_(&region), camera_(info.camera), width_(width_of(info.camera)), height_(height_of(info.camera)),
          closes_(columns_close(info.camera)), forward_(in_camera(moved_by(region.motion, seconds), info.camera_pose)),
          backward_(forward_.inverse()) {}

    const MovingRegion& region() const { return *region_; }
    /// In the axes of the picture's camera, about its centre.
    const RigidTransform& forward() const { return forward_; }
    const RigidTransform& backward() const { return backward_; }

    /// Calls reach(x, y, distance_m) for all pixels that pixel (x, y) at distance `before_m` may come to.
    template <typename Reach>
    void splat(int x, int y, float before_m, const Reach& reach) const {
        const auto centre = after({x + 0.5, y + 0.5}, before_m);
        if (!centre || !std::isfinite(before_m))
            return;
        // How large a pixel becomes: by where its neighbours come to.
        double half_u = 0.5, half_v = 0.5;
        for (const glm::dvec2 aside : {glm::dvec2(1, 0), glm::dvec2(0, 1)})
            if (const auto to = after(glm::dvec2(x + 0.5, y + 0.5) + aside, before_m)) {
                half_u += 0.5 * std::abs(column_difference(to->pixel.x - centre->pixel.x));
                half_v += 0.5 * std::abs(to->pixel.y - centre->pixel.y);
            }
        half_u = std::min(half_u, 0.5 * width_);
        half_v = std::min(half_v, max_half_height);
        const int left = int(std::ceil(centre->pixel.x - 0.5 - half_u)),
                  top = int(std::ceil(centre->pixel.y - 0.5 - half_v));
        const int right = int(std::floor(centre->pixel.x - 0.5 + half_u)),
                  bottom = int(std::floor(centre->pixel.y - 0.5 + half_v));
        for (int to_y = std::max(top, 0); to_y <= std::min(bottom, height_ - 1); ++to_y)
            for (int to_x = left; to_x <= right; ++to_x)
                if (const int column = closes_ ? (to_x % width_ + width_) % width_ : to_x;
                    column >= 0 && column < width_)
                    reach(column, to_y, float(centre->distance_m));
    }

    /// Where what pixel (x, y) shows at that distance was, in pixels; nothing: outside the picture.
    std::optional<glm::dvec2> before(int x, int y, float after_m) const {
        const glm::dvec3 was = backward_(double(after_m) * direction_of(camera_, x + 0.5, y + 0.5));
        const glm::dvec2 pixel = pixel_of(camera_, was);
        if (!(pixel.y >= 0 && pixel.y < height_))
            return std::nullopt;
        const double u = closes_ ? pixel.x - width_ * std::floor(pixel.x / width_) : pixel.x;
        if (!(u >= 0 && u < width_))
            return std::nullopt;
        return glm::dvec2(u, pixel.y);
    }

    double distance_after_m(glm::dvec2 pixel_before, float before_m) const {
        return glm::length(forward_(double(before_m) * direction_of(camera_, pixel_before.x, pixel_before.y)));
    }

    struct Tap {
        int x = 0, y = 0;
        double weight = 0;
    };
    /// Bilinear; beyond a border of the picture its pixels again, beyond a seam those on the other side.
    std::array<Tap, 4> taps(glm::dvec2 pixel) const {
        const glm::dvec2 corner = glm::floor(pixel - 0.5), part = pixel - 0.5 - corner;
        std::array<Tap, 4> taps;
        for (int k = 0; k < 4; ++k) {
            const int x = int(corner.x) + (k & 1), y = int(corner.y) + (k >> 1);
            taps[std::size_t(k)] = {closes_ ? (x + width_) % width_ : std::clamp(x, 0, width_ - 1),
                                    std::clamp(y, 0, height_ - 1),
                                    (k & 1 ? part.x : 1 - part.x) * (k >> 1 ? part.y : 1 - part.y)};
        }
        return taps;
    }

private:
    struct After {
        glm::dvec2 pixel;
        double distance_m = 0;
    };

    /// Regions move along the world's axes about the camera's centre.
    static RigidTransform in_camera(const RigidTransform& in_world, const Pose& pose) {
        const glm::dmat3 world_from_camera = glm::mat3_cast(pose.orientation);
        const glm::dmat3 camera_from_world = glm::transpose(world_from_camera);
        return {camera_from_world * in_world.rotation * world_from_camera, camera_from_world * in_world.translation_m};
    }

    double column_difference(double difference) const {
        return closes_ ? difference - width_ * std::floor(difference / width_ + 0.5) : difference;
    }

    std::optional<After> after(glm::dvec2 pixel, float before_m) const {
        const glm::dvec3 to = forward_(double(before_m) * direction_of(camera_, pixel.x, pixel.y));
        const double distance_m = glm::length(to);
        const glm::dvec2 at = pixel_of(camera_, to);
        // Streams may say anything, and a flat view has no end: neither may leave the numbers that pixels are.
        if (!(distance_m > 0 && distance_m < max_extrapolated_m && std::abs(at.x) < 4.0 * width_ &&
              std::abs(at.y) < 4.0 * height_))
            return std::nullopt;
        return After{at, distance_m};
    }

    const MovingRegion* region_;
    Camera camera_;
    int width_, height_;
    bool closes_;
    RigidTransform forward_, backward_;
};

}  // namespace equistream
