#pragma once
/// Scenes whose depth and colour have a closed form, as pictures and as a depth source.
#include <equistream/colour.h>

#include <client/depth/depth_source.h>
#include <client/warp/engine.h>
#include <client/warp/view.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <string>

namespace equistream::test {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

using Distance = std::function<double(const glm::dvec3& origin, const glm::dvec3& direction)>;
using Colour = std::function<glm::dvec3(const glm::dvec3& point_or_direction, double distance)>;

/// Distance along a unit direction to the plane n . x = c, in front of the origin only.
inline double to_plane(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& n, double c) {
    const double t = (c - glm::dot(n, origin)) / glm::dot(n, direction);
    return t > 0 ? t : infinity;
}

/// Nearest intersection with a sphere, from inside or outside.
inline double to_sphere(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& centre,
                        double radius) {
    const glm::dvec3 o = origin - centre;
    const double b = glm::dot(o, direction);
    const double discriminant = b * b - glm::dot(o, o) + radius * radius;
    if (discriminant < 0)
        return infinity;
    const double root = std::sqrt(discriminant);
    if (-b - root > 0)
        return -b - root;
    return -b + root > 0 ? -b + root : infinity;
}

class AnalyticDepth : public DepthSource {
public:
    explicit AnalyticDepth(Distance distance) : distance_(std::move(distance)) {}
    std::string_view name() const override { return "analytic"; }
    void set_time(double) override {}
    void cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) override {
        for (int y = 0; y < depth_m.height; ++y)
            for (int x = 0; x < depth_m.width; ++x)
                depth_m.pixel(x, y)[0] =
                    float(distance_(pose.position_m, pose.orientation * direction_of(camera, x + 0.5, y + 0.5)));
    }
    double distance(const glm::dvec3& origin, const glm::dvec3& direction) const {
        return distance_(origin, direction);
    }

private:
    Distance distance_;
};

/// A smooth function of a point or a direction, all channels in (0, 1); gradient at most `frequency` / 2 or so.
inline glm::dvec3 smooth(const glm::dvec3& p, double frequency) {
    return {0.5 + 0.25 * std::sin(frequency * p.x) * std::cos(frequency * p.y + 1),
            0.5 + 0.25 * std::sin(frequency * p.y + 0.5) * std::cos(frequency * p.z),
            0.5 + 0.25 * std::sin(frequency * p.z + 2) * std::cos(frequency * p.x)};
}

/// A picture sampled at pixel centres (no filter), with its depth.
struct Rendered {
    Camera camera;
    Pose pose;
    ByteImage rgb;
    FloatImage depth_m;

    SourceView source(double box_radius_m = 0) const {
        return {
            .rgb = rgb.view(), .camera = camera, .pose = pose, .depth_m = depth_m.view(), .box_radius_m = box_radius_m};
    }
};

inline Rendered render(const Distance& distance, const Colour& colour, const Camera& camera, const Pose& pose) {
    const int width = width_of(camera);
    const int height = height_of(camera);
    Rendered out{camera, pose, ByteImage(width, height, 3), FloatImage(width, height, 1)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 d = pose.orientation * direction_of(camera, x + 0.5, y + 0.5);
            const double r = distance(pose.position_m, d);
            const glm::dvec3 c = colour(std::isinf(r) ? d : pose.position_m + r * d, r);
            for (int k = 0; k < 3; ++k)
                out.rgb.pixel(x, y)[k] = std::uint8_t(std::floor(255 * c[k] + 0.5));
            out.depth_m.pixel(x, y)[0] = float(r);
        }
    return out;
}

/// What an eye's picture shows, in [0, 1]; rounding to 8 bits took at most `half_a_step`.
inline FloatImage displayed(const EyePicture& picture) {
    return widen_8bit(picture.rgb().view());
}
inline constexpr double half_a_step = 1 / 510.0;
/// Two roundings of nearly the same value may be one step apart.
inline constexpr double one_step = 1.01 / 255;

/// Of any sample; infinite if one is NaN.
inline double worst_difference(const FloatImage& a, const FloatImage& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.samples().size(); ++i) {
        const double difference = std::abs(double(a.samples()[i]) - double(b.samples()[i]));
        worst = std::isnan(difference) ? infinity : std::max(worst, difference);
    }
    return worst;
}

inline glm::dquat yaw_pitch(double yaw_rad, double pitch_rad) {
    return glm::angleAxis(-yaw_rad, glm::dvec3(0, 1, 0)) * glm::angleAxis(pitch_rad, glm::dvec3(1, 0, 0));
}

// A room with a mirror in its floor, in closed form: colours, depth, mask and where images lie.

/// A mirror in the floor of a painted room: behind the floor's plane the room is seen again, turned over.
struct MirrorRoom {
    static constexpr double floor_m = -1, mirror_half_width_m = 1.2;

    static glm::dvec3 in_mirror(const glm::dvec3& p) { return {p.x, 2 * floor_m - p.y, p.z}; }
    static double walls(const glm::dvec3& o, const glm::dvec3& d) {
        const double wall = to_plane(o, d, {0, 0, 1}, -4);
        const double side = std::min(to_plane(o, d, {1, 0, 0}, -2.5), to_plane(o, d, {1, 0, 0}, 2.5));
        return std::min({wall, side, to_plane(o, d, {0, 1, 0}, 2), to_plane(o, d, {0, 0, 1}, 3)});
    }
    static double depth(const glm::dvec3& o, const glm::dvec3& d) {
        return std::min(walls(o, d), to_plane(o, d, {0, 1, 0}, floor_m));
    }
    static bool mirrors(const glm::dvec3& p) {
        return std::abs(p.y - floor_m) < 1e-6 && std::abs(p.x) < mirror_half_width_m && p.z < -1 && p.z > -3.5;
    }
    /// From o, to where the image in a mirror lies; to the surface elsewhere.
    static double image_depth(const glm::dvec3& o, const glm::dvec3& d) {
        const double r = depth(o, d);
        if (!mirrors(o + r * d))
            return r;
        return r + walls(o + (r - 1e-9) * d, {d.x, -d.y, d.z});
    }
    static glm::dvec3 paint(const glm::dvec3& p) {
        return 0.5 + 0.5 * (smooth(p, 7) - 0.5) + 0.25 * (smooth(p, 21) - 0.5);
    }
};

struct MirrorView {
    Rendered picture;
    FloatImage specular, image_m;

    MirrorView(const Camera& camera, const Pose& pose)
        : picture(render(
              MirrorRoom::depth, [](const glm::dvec3& p, double) { return MirrorRoom::paint(p); }, camera, pose)),
          specular(width_of(camera), height_of(camera), 1), image_m(width_of(camera), height_of(camera), 1) {
        for (int y = 0; y < height_of(camera); ++y)
            for (int x = 0; x < width_of(camera); ++x) {
                const glm::dvec3 o = pose.position_m, d = pose.orientation * direction_of(camera, x + 0.5, y + 0.5);
                const double r = MirrorRoom::depth(o, d);
                const double image = MirrorRoom::image_depth(o, d);
                const bool mirror = MirrorRoom::mirrors(o + r * d);
                *specular.pixel(x, y) = mirror ? 1.0f : 0.0f;
                *image_m.pixel(x, y) = float(image);
                const glm::dvec3 colour = MirrorRoom::paint(mirror ? MirrorRoom::in_mirror(o + image * d) : o + r * d);
                for (int c = 0; c < 3; ++c)
                    picture.rgb.pixel(x, y)[c] = std::uint8_t(255 * colour[c] + 0.5);
            }
    }
    SourceView source() const {
        SourceView view = picture.source(0.15);
        view.specular = specular.view();
        view.virtual_depth_m = image_m.view();
        return view;
    }
};

// Pictures that nobody painted, for filling.

/// Gaps of all sizes, surfaces at a few depths with steps between.
struct RandomPicture {
    EyePicture picture;
    FloatImage depth_m;

    RandomPicture(int width, int height, std::mt19937& random) {
        const auto number = [&](int end) { return std::uniform_int_distribution<int>(0, end - 1)(random); };
        picture.rgba = ByteImage(width, height, 4, 255);
        picture.origin = ByteImage(width, height, 1, std::uint8_t(PixelOrigin::source));
        depth_m = FloatImage(width, height, 1, 4.0f);
        for (std::uint8_t& byte : picture.rgba.samples())
            byte = std::uint8_t(number(256));
        for (int box = 0; box < 6; ++box) {
            const int left = number(width), top = number(height), side = 1 << number(6);
            const float depth = box == 5 ? std::numeric_limits<float>::infinity() : 0.4f * float(1 + number(9));
            const bool open = number(2) == 1;
            for (int y = top; y < std::min(top + side, height); ++y)
                for (int x = left; x < std::min(left + side, width); ++x) {
                    *depth_m.pixel(x, y) = depth + 0.01f * float(x);
                    if (open)
                        *picture.origin.pixel(x, y) = 0;
                }
        }
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if (*picture.origin.pixel(x, y) == 0)
                    std::fill_n(picture.rgba.pixel(x, y), 4, std::uint8_t{0});
    }
};

}  // namespace equistream::test
