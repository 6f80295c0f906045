#include "plain_surface.h"

#include <client/warp/resample.h>
#include <equistream/bound.h>

#include <array>
#include <cassert>
#include <optional>

namespace equistream::plain {

namespace {

struct Tap {
    int x = 0, y = 0;
    double weight = 0;
};

/// The four samples around (u, v), or nothing where the source does not cover it.
std::optional<std::array<Tap, 4>> taps_around(const Camera& camera, glm::dvec2 p) {
    const int width = width_of(camera);
    const int height = height_of(camera);
    constexpr double edge = 0.02;
    if (!(p.x >= -edge && p.x <= width + edge && p.y >= -edge && p.y <= height + edge))
        return std::nullopt;
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    const bool closes = sphere && sphere->range.closes();
    const glm::dvec2 corner = glm::floor(p - 0.5);
    const glm::dvec2 a = p - 0.5 - corner;
    std::array<Tap, 4> taps;
    for (int k = 0; k < 4; ++k) {
        int x = int(corner.x) + k % 2;
        int y = int(corner.y) + k / 2;
        const bool over_north = y < 0 && closes && sphere->range.latitude_max > pi / 2 - 1e-9;
        const bool over_south = y >= height && closes && sphere->range.latitude_min < -pi / 2 + 1e-9;
        if (over_north || over_south)
            x += width / 2;
        x = closes ? (x % width + width) % width : std::clamp(x, 0, width - 1);
        y = std::clamp(y, 0, height - 1);
        taps[k] = {x, y, (k % 2 ? a.x : 1 - a.x) * (k / 2 ? a.y : 1 - a.y)};
    }
    return taps;
}

/// Chroma, in steps of 255, at a sample of luma.
double chroma(const ImageView<const std::uint8_t>& plane, int luma_x, int luma_y) {
    const double x = 0.5 * luma_x, y = 0.5 * luma_y - 0.25;
    const glm::dvec2 corner(std::floor(x), std::floor(y));
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
        const glm::dvec2 at = corner + glm::dvec2(k % 2, k / 2);
        const int i = std::clamp(int(at.x), 0, plane.width - 1), j = std::clamp(int(at.y), 0, plane.height - 1);
        sum += (1 - std::abs(at.x - x)) * (1 - std::abs(at.y - y)) * (plane.pixel(i, j)[0] - 128.0);
    }
    return sum / bt709::chroma_scale;
}

class ResampleEngine : public Engine {
public:
    ResampleEngine(bool surface, const EngineOptions& options) : surface_(surface), options_(options) {}

    std::string_view name() const override { return surface_ ? "eye-depth" : "rotation"; }
    DepthNeeds needs_depth(const Pose& source, const Pose& eye) const override {
        const bool moved = surface_ && !same_position(source, eye);
        return {.source = moved, .eye = moved};
    }
    void set_source(const SourceView& source) override { source_ = source; }

    void reproject(const EyeView& eye, EyePicture& picture) const override {
        picture.reset(eye.camera);
        for (int y = 0; y < eye.camera.height; ++y)
            for (int x = 0; x < eye.camera.width; ++x)
                if (colour(eye, x, y, picture.rgba.pixel(x, y)))
                    *picture.origin.pixel(x, y) = std::uint8_t(PixelOrigin::source);
    }

private:
    bool colour(const EyeView& eye, int x, int y, std::uint8_t* rgba) const {
        const bool moved = needs_depth(source_.pose, eye.pose).any();
        const glm::dvec3 ray = eye.pose.orientation * eye.camera.direction(x + 0.5, y + 0.5);
        glm::dvec3 from_source = ray;
        double distance_m = 1;
        if (moved) {
            const double depth_m = eye.depth_m.pixel(x, y)[0];
            if (!(depth_m > 0))
                return false;
            if (std::isfinite(depth_m))
                from_source = eye.pose.position_m + depth_m * ray - source_.pose.position_m;
            distance_m = std::isfinite(depth_m) ? glm::length(from_source) : depth_m;
        }
        const glm::dvec3 d = glm::conjugate(source_.pose.orientation) * from_source;
        auto taps = taps_around(source_.camera, pixel_of(source_.camera, d));
        if (!taps)
            return false;
        if (moved && shows_back(eye, x, y))
            return false;
        if (moved) {
            bool all = true;
            for (Tap& tap : *taps) {
                const bool same = same_surface(eye, x, y, distance_m, tap);
                tap.weight *= same ? 1 : 0;
                all = all && same;
            }
            if (!all && hidden(eye, pixel_of(source_.camera, d), distance_m))
                return false;
        }
        return mix(*taps, rgba);
    }

    bool mix(const std::array<Tap, 4>& taps, std::uint8_t* rgba) const {
        double sum = 0;
        for (const Tap& tap : taps)
            sum += tap.weight;
        if (!(sum > 0.1))
            return false;
        glm::dvec3 rgb(0);
        for (const Tap& tap : taps)
            rgb += tap.weight / sum * colour_of_sample(source_, tap.x, tap.y);
        for (int c = 0; c < 3; ++c)
            rgba[c] = std::uint8_t(rgb[c] + 0.5);
        rgba[3] = 255;
        return true;
    }

    double box_radius_m(const EyeView& eye) const {
        return std::max(source_.box_radius_m, glm::length(eye.pose.position_m - source_.pose.position_m));
    }

    /// bounded_inverse_depth with equal depths told apart inside the box too, where only they agree.
    double w_of(double distance_m, double box_m) const {
        if (std::isinf(distance_m))
            return 0;
        return box_m / std::max(distance_m - box_m, 1e-3 * distance_m);
    }

    double tolerance(const EyeView& eye) const {
        return std::sin(error_budget_rad(eye.camera.focal_px(), options_.error_budget_px));
    }

    bool same_surface(const EyeView& eye, int x, int y, double distance_m, const Tap& tap) const {
        const double sample_m = source_.depth_m.pixel(tap.x, tap.y)[0];
        if (!(sample_m > 0))
            return false;
        const double box = box_radius_m(eye);
        const double w = w_of(distance_m, box);
        const double w_sample = w_of(sample_m, box);
        if (std::abs(w - w_sample) <= tolerance(eye))
            return true;
        const double w_predicted = w_of(plane_distance(eye, x, y, tap), box);
        return w_sample >= std::min(w, w_predicted) - tolerance(eye) &&
               w_sample <= std::max(w, w_predicted) + tolerance(eye);
    }

    /// w of any sample, round a sphere, over its poles, or of the nearest in a picture that ends; NaN if unknown.
    double w_at(const EyeView& eye, int x, int y) const {
        const int width = width_of(source_.camera), height = height_of(source_.camera);
        const auto* sphere = std::get_if<EquirectCamera>(&source_.camera);
        const bool closes = sphere && sphere->range.closes();
        const bool north = closes && sphere->range.latitude_max > pi / 2 - 1e-9;
        const bool south = closes && sphere->range.latitude_min < -pi / 2 + 1e-9;
        if ((y < 0 && north) || (y >= height && south)) {
            y = y < 0 ? -1 - y : 2 * height - 1 - y;
            x += width / 2;
        }
        x = closes ? (x % width + width) % width : std::clamp(x, 0, width - 1);
        const double sample_m = source_.depth_m.pixel(x, std::clamp(y, 0, height - 1))[0];
        return sample_m > 0 ? w_of(sample_m, box_radius_m(eye)) : std::nan("");
    }

    /// Whether a smooth surface through the sixteen samples around a position runs before the point (resample.h).
    bool hidden(const EyeView& eye, glm::dvec2 position, double distance_m) const {
        const glm::dvec2 corner = glm::floor(position - 0.5), a = position - 0.5 - corner;
        double w[4][4];
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i)
                w[j][i] = w_at(eye, int(corner.x) + i - 1, int(corner.y) + j - 1);
        double bend = std::abs(w[1][1] - w[1][2] - w[2][1] + w[2][2]);
        glm::dvec2 sums(0);
        for (int line = 0; line < 4; ++line) {
            glm::dvec2 sum(0);
            for (int i = 0; i < 2; ++i) {
                const glm::dvec2 second = glm::abs(glm::dvec2(w[line][i] - 2 * w[line][i + 1] + w[line][i + 2],
                                                              w[i][line] - 2 * w[i + 1][line] + w[i + 2][line]));
                if (std::isnan(second.x + second.y))
                    return false;
                bend = std::max({bend, second.x, second.y});
                sum += second;
            }
            if (line == 1 || line == 2)
                sums = glm::max(sums, sum);
        }
        const double here = glm::mix(glm::mix(w[1][1], w[1][2], a.x), glm::mix(w[2][1], w[2][2], a.x), a.y);
        const double may_be_off = sums.x * a.x * (1 - a.x) + sums.y * a.y * (1 - a.y);
        return bend <= max_bend * tolerance(eye) &&
               here - w_of(distance_m, box_radius_m(eye)) > min_behind * tolerance(eye) + may_be_off;
    }

    /// Whether every plane through the eye's point and a neighbour in each direction has the eye and the source on
    /// different sides.
    bool shows_back(const EyeView& eye, int x, int y) const {
        if (std::isinf(eye.depth_m.pixel(x, y)[0]))
            return false;
        const glm::dvec3 p = point(eye, x, y);
        int planes = 0;
        for (const int i : {-1, 1})
            for (const int j : {-1, 1}) {
                if (!std::isfinite(inverse_planar(eye, x + i, y)) || !std::isfinite(inverse_planar(eye, x, y + j)))
                    continue;
                const glm::dvec3 normal = glm::cross(point(eye, x + i, y) - p, point(eye, x, y + j) - p);
                const double eye_side = glm::dot(normal, eye.pose.position_m - p);
                if (glm::dot(normal, source_.pose.position_m - p) * eye_side >= 0)
                    return false;
                ++planes;
            }
        return planes > 0;
    }

    /// Distance from the source's centre, along the sample's ray, to the plane through the eye's point and its
    /// neighbours; +inf where the ray runs away from it.
    double plane_distance(const EyeView& eye, int x, int y, const Tap& tap) const {
        const glm::dvec3 p = point(eye, x, y);
        const glm::dvec3 along_x = tangent(eye, x, y, 1, 0);
        const glm::dvec3 along_y = tangent(eye, x, y, 0, 1);
        const glm::dvec3 normal = glm::cross(along_x, along_y);
        const glm::dvec3 q = source_.pose.orientation * direction_of(source_.camera, tap.x + 0.5, tap.y + 0.5);
        const double t = glm::dot(normal, p - source_.pose.position_m) / glm::dot(normal, q);
        return t > 0 && t < 1e9 ? t : std::numeric_limits<double>::infinity();
    }

    double inverse_planar(const EyeView& eye, int x, int y) const {
        if (x < 0 || y < 0 || x >= eye.camera.width || y >= eye.camera.height)
            return std::nan("");
        return -1 / (eye.camera.direction(x + 0.5, y + 0.5).z * eye.depth_m.pixel(x, y)[0]);
    }

    glm::dvec3 point(const EyeView& eye, int x, int y) const {
        const double depth_m = std::min<double>(eye.depth_m.pixel(x, y)[0], 1e9);
        return eye.pose.position_m + eye.pose.orientation * (depth_m * eye.camera.direction(x + 0.5, y + 0.5));
    }

    /// From the pixel's point to the neighbour's that is nearer to it in depth; without one, across the view.
    glm::dvec3 tangent(const EyeView& eye, int x, int y, int dx, int dy) const {
        const double here = inverse_planar(eye, x, y);
        const double before = std::abs(inverse_planar(eye, x - dx, y - dy) - here);
        const double after = std::abs(inverse_planar(eye, x + dx, y + dy) - here);
        if (std::isfinite(before) && !(before > after))
            return point(eye, x, y) - point(eye, x - dx, y - dy);
        if (std::isfinite(after))
            return point(eye, x + dx, y + dy) - point(eye, x, y);
        return eye.pose.orientation * glm::dvec3(dx, -dy, 0);
    }

    bool surface_;
    EngineOptions options_;
    SourceView source_;
};

}  // namespace

glm::dvec3 colour_of_sample(const SourceView& source, int x, int y) {
    using namespace bt709;
    if (source.rgb.data != nullptr) {
        const std::uint8_t* sample = source.rgb.pixel(x, y);
        return {sample[0], sample[1], sample[2]};
    }
    const double grey = (source.yuv.y.pixel(x, y)[0] - 16) / luma_scale;
    const double cb = chroma(source.yuv.cb, x, y), cr = chroma(source.yuv.cr, x, y);
    const glm::dvec3 sample(grey + cr_divisor * cr, grey + green_from_cb * cb + green_from_cr * cr,
                            grey + cb_divisor * cb);
    return glm::round(glm::clamp(sample, 0.0, 255.0));
}

std::unique_ptr<Engine> make_resample_engine(bool surface, const EngineOptions& options) {
    return std::make_unique<ResampleEngine>(surface, options);
}

}  // namespace equistream::plain
