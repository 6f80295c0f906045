#include "history.h"

#include <plugin/export/parallel.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <limits>

namespace equistream {
namespace {

/// Pixels. A host answers in single precision, so what stands still seems to move a little.
constexpr float still_px = 1.0f / 256;
/// Of a coordinate of the world, when a host finds where a point was.
constexpr double roundings = 4;
/// By which the mean of what moves less than that lags at most, unless `frames` allows more.
constexpr float lag_px = 0.25f;
/// Of a pixel: a point that is where its motion says within this has not moved by itself.
constexpr double static_px = 0.1;
/// Of the distance.
constexpr float depth_tolerance = 0.01f, moving_depth_tolerance = 0.2f, shown_tolerance = 0.05f;
/// Cosines between normals.
constexpr float normal_tolerance = 0.9f, turning_normal_tolerance = 0.8f;
/// Two surfaces are apart by more pixels than a surface bends by from one to the next, and slide along each other.
constexpr float rim_gap_px = 2, sliding_px = 0.05f;
/// Less of a bilinear look-up's weight on the same thing is too far aside.
constexpr float min_weight = 0.1f;
/// Earlier frames that count where resampling blurs: where something slides along something else, what a pixel shows of
/// each changes; beside it neighbours are missing. More would gain less noise than they cost.
constexpr float rim_frames = 3, edge_frames = 5;

/// But for how a path's numbers are rounded.
bool is_held(const Pose& before, const Pose& now) {
    constexpr double rounding = 1e-12;
    return glm::length(now.position_m - before.position_m) <= rounding * (1 + glm::length(now.position_m)) &&
           std::abs(glm::dot(now.orientation, before.orientation)) >= 1 - rounding;
}

/// Between the second and the third of four samples: cubic convolution (Keys 1981).
std::array<float, 4> cubic(float t) {
    return {t * (-0.5f + t * (1 - 0.5f * t)), 1 + t * t * (-2.5f + 1.5f * t), t * (0.5f + t * (2 - 1.5f * t)),
            t * t * (-0.5f + 0.5f * t)};
}

}  // namespace

/// What a pixel looks for in the frame before, and where.
struct History::Sought {
    const Seen& own;   ///< what the pixel itself sees
    const Seen& here;  ///< what its picture moves with
    float u, v;
    float moved_px;        ///< on the longer axis
    float rounding_px;     ///< by which what stands still may seem to have moved
    bool still;            ///< in the same pixel
    bool is_static;        ///< where the point was is known exactly
    glm::vec3 point_m{0};  ///< from the camera before
    float distance_m, shown_m;
    float slide_px;  ///< between points 1 and 2 metres away, at most
};

void History::see(const Frame& frame) {
    const glm::dquat& world_from_camera = frame.info.camera_pose.orientation;
    const FloatImage &depth = frame.planes.at("depth"), &normal = frame.planes.at("normal"),
                     &specular = frame.planes.at("specular"), &shown = frame.planes.at("virtual_depth");
    const IdImage &object = frame.ids.at("object_id"), &instance = frame.ids.at("instance_id");
    for_each_row(height_, [&](int y) {
        Seen* to = &seen_[0][index(0, y)];
        for (int x = 0; x < width_; ++x, ++to) {
            const float distance = *depth.pixel(x, y);
            const glm::vec3 direction(world_from_camera * direction_of(camera_, x + 0.5, y + 0.5));
            *to = {};
            to->endless = !std::isfinite(distance);
            to->point_m = to->endless ? direction : distance * direction;
            to->shown_m = *shown.pixel(x, y);
            to->normal = glm::vec3(normal.pixel(x, y)[0], normal.pixel(x, y)[1], normal.pixel(x, y)[2]);
            to->object = *object.pixel(x, y);
            to->instance = *instance.pixel(x, y);
            to->specular = *specular.pixel(x, y) > 0.5f && !to->endless;
        }
    });
}

double History::pixel_rad() const {
    return std::visit([](const auto& camera) { return camera.pixel_angle_rad(); }, camera_);
}

/// Whether beside a pixel there is another surface, before it or behind it, that moves otherwise.
bool History::is_rim(const Planes& planes, int x, int y) const {
    const Seen& here = seen_[0][index(x, y)];
    const auto motion = [&](std::size_t at) {
        const float* m = (seen_[0][at].specular ? planes.virtual_backward : planes.backward) + 2 * at;
        return glm::vec2(m[0], m[1]);
    };
    const glm::vec2 moved = motion(index(x, y));
    const float distance_m = glm::length(here.point_m);
    const float gap_m = rim_gap_px * static_cast<float>(pixel_rad()) * distance_m;
    for (int j = -1; j < 2; ++j)
        for (int i = -1; i < 2; ++i) {
            const std::ptrdiff_t at = place(x + i, y + j);
            if ((i == 0 && j == 0) || at < 0)
                continue;
            const Seen& there = seen_[0][static_cast<std::size_t>(at)];
            const glm::vec2 apart = glm::abs(motion(static_cast<std::size_t>(at)) - moved);
            const float across = closes_ ? std::min(apart.x, static_cast<float>(width_) - apart.x) : apart.x;
            if (std::max(across, apart.y) < sliding_px || (here.endless && there.endless))
                continue;
            if (here.endless != there.endless || here.specular != there.specular)
                return true;
            const float deeper_m = std::abs(glm::length(there.point_m) - distance_m);
            const float off_plane_m = std::abs(glm::dot(here.normal, there.point_m - here.point_m));
            if (std::min(deeper_m, off_plane_m) > gap_m)
                return true;
        }
    return false;
}

/// Of a pixel and those around it.
glm::ivec2 History::nearest_around(int x, int y) const {
    glm::ivec2 nearest(x, y);
    float nearest_m = std::numeric_limits<float>::infinity();
    for (int j = -1; j < 2; ++j)
        for (int i = -1; i < 2; ++i) {
            const std::ptrdiff_t at = place(x + i, y + j);
            if (at < 0)
                continue;
            const Seen& there = seen_[0][static_cast<std::size_t>(at)];
            const float distance_m = glm::length(there.point_m);
            if (!there.endless && !there.specular && distance_m < nearest_m) {
                nearest_m = distance_m;
                nearest = {x + i, y + j};
            }
        }
    return nearest;
}

void History::find_rims(const Planes& planes) {
    for_each_row(height_, [&](int y) {
        for (int x = 0; x < width_; ++x)
            seen_[0][index(x, y)].rim = is_rim(planes, x, y);
    });
}

History::Sought History::sought(const Planes& planes, int x, int y, const Poses& poses) const {
    const Seen& own = seen_[0][index(x, y)];
    const glm::ivec2 lead = own.rim && !own.specular ? nearest_around(x, y) : glm::ivec2(x, y);
    const std::ptrdiff_t at = place(lead.x, lead.y);
    const Seen& here = seen_[0][static_cast<std::size_t>(at)];
    const float* const motion = (here.specular ? planes.virtual_backward : planes.backward) + 2 * at;
    const auto& [before, now] = poses;
    const glm::dvec3 shift_m = now.position_m - before.position_m;
    Sought s{own,
             here,
             static_cast<float>(x) + 0.5f + motion[0],
             static_cast<float>(y) + 0.5f + motion[1],
             std::max(std::abs(motion[0]), std::abs(motion[1])),
             0,
             false,
             true,
             here.point_m,
             0,
             here.shown_m,
             static_cast<float>(2 * glm::length(shift_m) / pixel_rad())};
    s.still = is_held(before, now) && s.moved_px < still_px;
    if (!here.endless)
        s.point_m += glm::vec3(shift_m);
    s.distance_m = glm::length(s.point_m);
    if (!here.endless) {
        const double world_m = glm::length(now.position_m) + double(s.distance_m);
        s.rounding_px = float(roundings * FLT_EPSILON * world_m / double(s.distance_m) / pixel_rad());
    }
    if (here.specular && std::isfinite(here.shown_m))
        s.shown_m = glm::length(here.shown_m * glm::normalize(here.point_m) + glm::vec3(shift_m));
    if (!here.endless && !here.specular && !s.still) {
        const glm::dvec3 looked_at =
            before.orientation * direction_of(camera_, double(s.u) + lead.x - x, double(s.v) + lead.y - y);
        s.is_static = glm::length(looked_at - glm::dvec3(s.point_m / s.distance_m)) < static_px * pixel_rad();
    }
    return s;
}

/// Of a pixel, also beyond the seam and the poles; -1 outside the picture.
std::ptrdiff_t History::place(int x, int y) const {
    if ((y < 0 && north_pole_) || (y >= height_ && south_pole_)) {
        y = y < 0 ? -1 - y : 2 * height_ - 1 - y;
        x += width_ / 2;
    }
    if (closes_)
        x = x < 0 || x >= width_ ? (x % width_ + width_) % width_ : x;
    if (x < 0 || x >= width_ || y < 0 || y >= height_)
        return -1;
    return static_cast<std::ptrdiff_t>(y) * width_ + x;
}

bool History::is_same(const Sought& sought, int x, int y) const {
    const std::ptrdiff_t at = place(x, y);
    if (at < 0 || !(means_[1][static_cast<std::size_t>(at)].count > 0))
        return false;
    const Seen& there = seen_[1][static_cast<std::size_t>(at)];
    const Seen& here = sought.here;
    if (there.object != here.object || there.instance != here.instance || there.endless != here.endless ||
        there.specular != here.specular || (there.rim && !sought.own.rim && !sought.still))
        return false;
    if (here.endless)
        return true;
    const float alike = glm::dot(here.normal, there.normal);
    if (here.normal != glm::vec3(0) &&
        alike < (sought.is_static && !here.specular ? normal_tolerance : turning_normal_tolerance))
        return false;
    if (here.specular)
        return there.shown_m == sought.shown_m ||
               std::abs(there.shown_m - sought.shown_m) < shown_tolerance * sought.shown_m;
    const float deeper_m = std::abs(glm::length(there.point_m) - sought.distance_m);
    if (!sought.is_static)
        return deeper_m < moving_depth_tolerance * sought.distance_m;
    const float off_plane_m = std::abs(glm::dot(here.normal, there.point_m - sought.point_m));
    return std::min(deeper_m, off_plane_m) < depth_tolerance * sought.distance_m;
}

bool History::is_own_rim(const Sought& sought, int x, int y) const {
    const std::ptrdiff_t at = place(x, y);
    const Seen* const there = at < 0 ? nullptr : &seen_[1][static_cast<std::size_t>(at)];
    return there != nullptr && there->rim && there->object == sought.own.object &&
           there->instance == sought.own.instance;
}

/// Whether what is seen there moves as what is sought, though it may be another thing: what both show where they meet
/// moves along too. At a rim everything does: it is a mean of what is on both sides.
bool History::goes_along(const Sought& sought, int x, int y) const {
    const std::ptrdiff_t at = place(x, y);
    if (at < 0 || !(means_[1][static_cast<std::size_t>(at)].count > 0))
        return false;
    if (sought.own.rim || is_same(sought, x, y))
        return true;
    const Seen& here = sought.here;
    const Seen& there = seen_[1][static_cast<std::size_t>(at)];
    const float near_there = there.endless ? 0 : 1 / glm::length(there.point_m);
    const float near_here = here.endless ? 0 : 1 / sought.distance_m;
    return sought.is_static && !here.specular && there.fixed && !there.specular && !there.rim &&
           sought.slide_px * std::abs(near_there - near_here) < sliding_px;
}

/// From a middle four that go along; another that does not is taken for the nearest of these. No colour is beyond the
/// four, or the sun would get a dark ring that grows from frame to frame. Whether all go along.
bool History::sharpen(Mean& mean, const Sought& sought, glm::ivec2 corner, glm::vec2 past) const {
    const std::array<float, 4> across = cubic(past.x), along = cubic(past.y);
    mean.colour = glm::vec4(0);
    mean.denoised = glm::vec3(0);
    mean.recent = mean.innovation = 0;
    glm::vec4 low(std::numeric_limits<float>::infinity()), high = -low;
    glm::vec3 denoised_low(low), denoised_high(high);
    float recent_low = low.x, recent_high = high.x;
    bool whole = true;
    for (int j = -1; j < 3; ++j)
        for (int i = -1; i < 3; ++i) {
            const int x = std::clamp(i, 0, 1), y = std::clamp(j, 0, 1);
            const bool here = (x == i && y == j) || goes_along(sought, corner.x + i, corner.y + j);
            whole = whole && here;
            const Mean& m =
                means_[1][static_cast<std::size_t>(place(corner.x + (here ? i : x), corner.y + (here ? j : y)))];
            const float weight = across[static_cast<std::size_t>(i + 1)] * along[static_cast<std::size_t>(j + 1)];
            mean.colour += weight * m.colour;
            mean.denoised += weight * m.denoised;
            mean.recent += weight * m.recent;
            mean.innovation += weight * m.innovation;
            if (x == i && y == j) {
                low = glm::min(low, m.colour);
                high = glm::max(high, m.colour);
                recent_low = std::min(recent_low, m.recent);
                recent_high = std::max(recent_high, m.recent);
                denoised_low = glm::min(denoised_low, m.denoised);
                denoised_high = glm::max(denoised_high, m.denoised);
            }
        }
    mean.colour = glm::clamp(mean.colour, low, high);
    mean.denoised = glm::clamp(mean.denoised, denoised_low, denoised_high);
    mean.recent = std::clamp(mean.recent, recent_low, recent_high);
    return whole;
}

/// Sharp where everything around is the same thing, so that a picture carried on for long does not blur; elsewhere few
/// frames count. Count and variance never come out better than their neighbours'.
History::Mean History::found(const Sought& sought) const {
    const float u = sought.u - 0.5f, v = sought.v - 0.5f;
    if (!(std::abs(u) < 1e6f && std::abs(v) < 1e6f))
        return {};
    const int left = static_cast<int>(std::floor(u)), top = static_cast<int>(std::floor(v));
    const auto at = [&](int x, int y) -> const Mean& { return means_[1][static_cast<std::size_t>(place(x, y))]; };
    if (sought.still) {
        const int x = static_cast<int>(std::lround(u)), y = static_cast<int>(std::lround(v));
        if (!is_same(sought, x, y))
            return {};
        Mean same = at(x, y);
        same.most = sought.moved_px > sought.rounding_px ? std::max(frames_, lag_px / sought.moved_px)
                                                         : std::numeric_limits<float>::infinity();
        same.stayed = true;
        return same;
    }
    const float right = u - static_cast<float>(left), down = v - static_cast<float>(top);
    Mean sum;
    float weights = 0, shares = 0, recent_shares = 0;
    float same = 0;
    int along = 0;
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const float weight = (i == 0 ? 1 - right : right) * (j == 0 ? 1 - down : down);
            if (!goes_along(sought, left + i, top + j))
                continue;
            ++along;
            if (sought.own.rim ? is_own_rim(sought, left + i, top + j) : is_same(sought, left + i, top + j))
                same += weight;
            const Mean& m = at(left + i, top + j);
            weights += weight;
            shares += weight / m.count;
            recent_shares += m.recent_count > 0 ? weight / m.recent_count : 0;
            sum.colour += weight * m.colour;
            sum.denoised += weight * m.denoised;
            sum.variance += weight * m.variance;
            sum.freedom += weight * m.freedom;
            sum.recent += weight * m.recent;
            sum.innovation += weight * m.innovation;
        }
    if (same < min_weight)
        return {};
    const float scale = 1 / weights;
    sum.colour *= scale;
    sum.denoised *= scale;
    sum.variance *= scale;
    sum.freedom *= scale;
    sum.recent *= scale;
    sum.innovation *= scale;
    sum.count = weights / shares;
    sum.recent_count = weights / recent_shares;
    const bool whole = along == 4 && sharpen(sum, sought, {left, top}, {right, down});
    sum.most = std::min(frames_, sought.own.rim ? rim_frames : whole ? frames_ : edge_frames);
    return sum;
}

History::Mean History::carried(const Planes& planes, int x, int y, const Poses& poses) {
    const Sought what = sought(planes, x, y, poses);
    seen_[0][index(x, y)].fixed = what.is_static;
    return found(what);
}

}  // namespace equistream
