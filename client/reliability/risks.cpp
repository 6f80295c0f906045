#include "risks.h"

#include "surroundings.h"

#include "../reproject/eye_rays.h"

#include <equistream/bound.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace equistream {

namespace {

constexpr float most_halvings = 4;
constexpr float most_radii_outside = 2;
/// Of a tenth of a millimetre: squares of it and of what is made of it stay finite.
constexpr float largest_inverse_m = 1e4f;

/// log2 within 0.01 for x > 0, rising wherever x does: a straight line from power to power would err by 0.09, its
/// quadratic correction leaves a tenth of that.
inline float fast_log2(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const float exponent = float(int(bits >> 23) - 127);
    const float f = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u) - 1;
    return exponent + f + 0.346607f * f * (1 - f);
}

inline float log_of(float x) {
    return fast_log2(1 + x);
}

/// The nearer to zero of the differences to either side; `before` or `after` may be the pixel itself.
inline float believed_slope(float before, float here, float after) {
    const float a = here - before, b = after - here;
    return std::abs(a) <= std::abs(b) ? a : b;
}

/// Rows of a sphere per radian; a flat view's at its middle, where they are fewest.
double density_per_rad(const Camera& camera) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera))
        return sphere->height / sphere->range.latitude_span();
    return std::get<PerspectiveCamera>(camera).focal_px();
}

ImageView<const float> depth_of(const EyeView& eye, const EyePicture& picture) {
    if (eye.depth_m.data != nullptr)
        return eye.depth_m;
    return picture.depth_m.empty() ? ImageView<const float>{} : picture.depth_m.view();
}

/// 1 / planar depth; 0 for a miss and where there is no depth.
FloatImage inverse_planar_depth(const PerspectiveCamera& camera, ImageView<const float> depth_m) {
    FloatImage inverse(depth_m.width, depth_m.height, 1);
    const auto inverse_focal = float(1 / camera.focal_px());
    tbb::parallel_for(tbb::blocked_range<int>(0, depth_m.height, 32), [&](const tbb::blocked_range<int>& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const float b = (float(y) + 0.5f - 0.5f * float(camera.height)) * inverse_focal;
            const float* depth = depth_m.row(y);
            float* q = inverse.pixel(0, y);
            for (int x = 0; x < depth_m.width; ++x) {
                const float a = (float(x) + 0.5f - 0.5f * float(camera.width)) * inverse_focal;
                const float value = std::sqrt(1 + a * a + b * b) / depth[x];
                q[x] = depth[x] > 0 ? std::min(value, largest_inverse_m) : 0.0f;
            }
        }
    });
    return inverse;
}

}  // namespace

struct RiskPicture::State {
    const SourceView& source;
    const EyePicture& picture;
    const PerspectiveCamera camera;
    glm::dquat source_from_eye{1, 0, 0, 0};
    Vec3f centre;          ///< of the source in the eye's axes
    float baseline_m = 0;  ///< from the source to the eye
    float focal_px = 1;
    float density = 1;         ///< source pixels per radian over the eye's at its middle
    float outside = 0;         ///< radii beyond the head box
    float depth_error_px = 0;  ///< by which the depth's tolerance displaces a pixel
    int step = 1;              ///< a source pixel, in pixels of the eye
    FloatImage inverse_planar;
    ByteImage closeness, filled;
    Differences differences;

    State(const SourceView& source_view, const EyeView& eye, const EyePicture& eye_picture,
          const ReliabilityOptions& options)
        : source(source_view), picture(eye_picture), camera(eye.camera),
          source_from_eye(glm::conjugate(source_view.pose.orientation) * eye.pose.orientation) {
        const glm::dvec3 centre_world = source.pose.position_m - eye.pose.position_m;
        const glm::dvec3 in_eye = glm::conjugate(eye.pose.orientation) * centre_world;
        centre = {float(in_eye.x), float(in_eye.y), float(in_eye.z)};
        baseline_m = float(glm::length(centre_world));
        focal_px = float(camera.focal_px());
        density = float(density_per_rad(source.camera) / camera.focal_px());
        step = std::clamp(int(std::lround(1 / density)), 1, 8);
        const double box = source.box_radius_m > 0 ? source.box_radius_m : baseline_m;
        if (box > 0) {
            const double share = baseline_m / box;
            outside = float(std::clamp(share - 1 - 1e-6, 0.0, double(most_radii_outside)));
            depth_error_px = float(options.depth_tolerance_w * share * camera.focal_px());
        }
        const ImageView<const float> depth = depth_of(eye, picture);
        float least_step = 0;
        if (depth.data != nullptr) {
            inverse_planar = inverse_planar_depth(camera, depth);
            // Far outside the box w is B / r, so a step of w is B times one of 1 / r.
            least_step = float(error_budget_rad(camera.focal_px()) / std::max<double>(baseline_m, 1e-6));
        }
        closeness = silhouette_closeness(inverse_planar, picture.origin, least_step);
        filled = fill_depth(picture.origin);
        differences = equistream::differences(picture.rgba, step);
    }

    void shape_risks(int y, const float* detail, RiskRow& out) const;
    void flat_risks(const float* detail, RiskRow& out) const;
    void specular_risk(int y, RiskRow& out) const;
};

/// Without depth nothing is known of the surface: it is taken to face the eye, a metre away.
void RiskPicture::State::flat_risks(const float* detail, RiskRow& out) const {
    const float halvings = std::clamp(-std::log2(density), 0.0f, most_halvings);
    const float doublings = std::clamp(std::log2(density), 0.0f, most_halvings);
    const float parallax = std::log2(1 + focal_px * baseline_m);
    for (int x = 0; x < out.width; ++x) {
        out.of(Risk::blur)[x] = detail[x] * halvings;
        out.of(Risk::minification)[x] = detail[x] * doublings;
        out.of(Risk::grazing)[x] = 0;
        out.of(Risk::parallax)[x] = parallax;
    }
}

void RiskPicture::State::shape_risks(int y, const float* detail, RiskRow& out) const {
    const int width = out.width, height = inverse_planar.height();
    const float* q = inverse_planar.pixel(0, y);
    const float* above = inverse_planar.pixel(0, std::max(0, y - 1));
    const float* below = inverse_planar.pixel(0, std::min(height - 1, y + 1));
    const float inverse_focal = 1 / focal_px;
    const float b = (0.5f * float(camera.height) - float(y) - 0.5f) * inverse_focal;
    float* blur = out.of(Risk::blur);
    float* minification = out.of(Risk::minification);
    float* grazing = out.of(Risk::grazing);
    float* parallax = out.of(Risk::parallax);
    for (int x = 0; x < width; ++x) {
        const float a = (float(x) + 0.5f - 0.5f * float(width)) * inverse_focal;
        const float length2 = 1 + a * a + b * b;
        // On a plane n . P = 1 the inverse planar depth is n . (a, b, -1): its slopes are the plane.
        const float nx = believed_slope(q[std::max(0, x - 1)], q[x], q[std::min(width - 1, x + 1)]) * focal_px;
        const float ny = -believed_slope(above[x], q[x], below[x]) * focal_px;
        const float nz = nx * a + ny * b - q[x];
        const float n2 = nx * nx + ny * ny + nz * nz;
        const float cosine2 = q[x] * q[x] / (n2 * length2 + 1e-30f);
        const float inverse_r = q[x] / std::sqrt(length2);
        // Of the point over its distance from the eye, so that misses need no case of their own.
        const float sx = a / std::sqrt(length2) - centre.x * inverse_r;
        const float sy = b / std::sqrt(length2) - centre.y * inverse_r;
        const float sz = -1 / std::sqrt(length2) - centre.z * inverse_r;
        const float nearer2 = 1 / std::max(sx * sx + sy * sy + sz * sz, 1e-6f);
        const float facing = std::abs(1 - nx * centre.x - ny * centre.y - nz * centre.z);
        // Density of the source's samples on the surface over that of the eye's, squared.
        const float size2 =
            density * density / (length2 * std::sqrt(length2)) * nearer2 * std::sqrt(nearer2) * std::max(facing, 1e-3f);
        const float doublings = 0.5f * fast_log2(size2);
        const float halvings_of_cosine = q[x] > 0 ? -0.5f * fast_log2(std::max(cosine2, 1e-6f)) : 0.0f;
        blur[x] = detail[x] * std::clamp(-doublings, 0.0f, most_halvings);
        minification[x] = detail[x] * std::clamp(doublings, 0.0f, most_halvings);
        grazing[x] = detail[x] * std::clamp(halvings_of_cosine, 0.0f, most_halvings);
        parallax[x] = log_of(focal_px * baseline_m * inverse_r);
    }
}

void RiskPicture::State::specular_risk(int y, RiskRow& out) const {
    float* specular = out.of(Risk::specular);
    std::fill_n(specular, out.width, 0.0f);
    if (source.specular.data == nullptr)
        return;
    const bool moved = !inverse_planar.empty();
    const glm::dvec3 origin(centre.x, centre.y, centre.z);
    for (int x = 0; x < out.width; ++x) {
        glm::dvec3 towards = camera.direction(x + 0.5, y + 0.5);
        const float q = moved ? inverse_planar.pixel(x, y)[0] : 0.0f;
        towards /= std::max(-towards.z, 1e-9);
        const glm::dvec2 at = pixel_of(source.camera, source_from_eye * (towards - double(q) * origin));
        if (!(at.x >= 0 && at.y >= 0 && at.x <= source.specular.width && at.y <= source.specular.height))
            continue;
        const int column = std::min(int(at.x), source.specular.width - 1);
        const int row = std::min(int(at.y), source.specular.height - 1);
        const float flag = std::clamp(source.specular.pixel(column, row)[0], 0.0f, 1.0f);
        specular[x] = flag * (1 + out.of(Risk::parallax)[x]);
    }
}

RiskPicture::RiskPicture(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                         const ReliabilityOptions& options)
    : state_(std::make_unique<State>(source, eye, picture, options)) {}
RiskPicture::~RiskPicture() = default;

bool RiskPicture::has_depth() const {
    return !state_->inverse_planar.empty();
}

void RiskPicture::row(int y, RiskRow& out) const {
    const State& s = *state_;
    const std::uint8_t* difference = s.differences.contrast.pixel(0, y);
    const std::uint8_t* bend = s.differences.detail.pixel(0, y);
    float* contrast = out.of(Risk::contrast);
    float* detail = out.of(Risk::detail);
    for (int x = 0; x < out.width; ++x) {
        contrast[x] = log_of(0.5f * float(difference[x]));
        detail[x] = log_of(0.5f * float(bend[x]));
    }
    if (has_depth())
        s.shape_risks(y, detail, out);
    else
        s.flat_risks(detail, out);
    s.specular_risk(y, out);
    const std::uint8_t* closeness = s.closeness.pixel(0, y);
    const std::uint8_t* filled = s.filled.pixel(0, y);
    const std::uint8_t* rgba = s.picture.rgba.pixel(0, y);
    const float depth_error = s.depth_error_px;
    for (int x = 0; x < out.width; ++x) {
        out.of(Risk::silhouette_0)[x] = closeness[x] >= 3 ? 1.0f : 0.0f;
        out.of(Risk::silhouette_1)[x] = closeness[x] >= 2 ? 1.0f : 0.0f;
        out.of(Risk::silhouette_2)[x] = closeness[x] >= 1 ? 1.0f : 0.0f;
        out.of(Risk::depth_error)[x] = log_of(depth_error * float(difference[x]));
        out.of(Risk::outside)[x] = s.outside;
        out.of(Risk::fill_depth)[x] = log_of(float(filled[x]));
        out.of(Risk::brightness)[x] = float(std::max({rgba[4 * x], rgba[4 * x + 1], rgba[4 * x + 2]})) * (1 / 255.0f);
    }
}

FloatImage reliability_risks(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options) {
    const RiskPicture risks(source, eye, picture, options);
    FloatImage planes(picture.origin.width(), picture.origin.height(), risk_count);
    RiskRow row(planes.width());
    for (int y = 0; y < planes.height(); ++y) {
        risks.row(y, row);
        for (int k = 0; k < risk_count; ++k)
            for (int x = 0; x < planes.width(); ++x)
                planes.pixel(x, y)[k] = row.of(Risk(k))[x];
    }
    return planes;
}

}  // namespace equistream
