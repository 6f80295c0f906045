#include "plain_engines.h"

#include <client/confidence/coefficients.h>
#include <client/confidence/reliability.h>
#include <client/reflections/specular.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <vector>

namespace equistream::plain {

using formulas::log2_correction;
using formulas::min_cosine2;
using formulas::min_distance2;
using formulas::min_facing;
using formulas::min_length2;

namespace {

/// log2 within 0.01 for x > 0, rising wherever x does: a straight line from power to power would err by 0.09, its
/// quadratic correction leaves a tenth of that.
inline float fast_log2(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const float exponent = float(int(bits >> 23) - 127);
    const float f = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u) - 1;
    return exponent + f + log2_correction * f * (1 - f);
}

inline float log_of(float x) {
    return fast_log2(1 + x);
}

/// The nearer to zero of the differences to either side; `before` or `after` may be the pixel itself.
inline float believed_slope(float before, float here, float after) {
    const float a = here - before, b = after - here;
    return std::abs(a) <= std::abs(b) ? a : b;
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
                q[x] = depth[x] > 0 ? std::min(value, max_inverse_m) : 0.0f;
            }
        }
    });
    return inverse;
}

/// One row of every risk, each contiguous.
struct RiskRow {
    explicit RiskRow(int pixels) : width(pixels), samples(std::size_t(pixels) * risk_count) {}
    float* of(Risk risk) { return samples.data() + std::size_t(risk) * std::size_t(width); }
    const float* of(Risk risk) const { return samples.data() + std::size_t(risk) * std::size_t(width); }

    int width = 0;
    std::vector<float> samples;
};

/// What a picture's risks are computed from; borrows its arguments. Rows may be asked for by any number of threads.
class RiskPicture {
public:
    RiskPicture(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                const ReliabilityOptions& options);
    ~RiskPicture();

    void row(int y, RiskRow& out) const;
    /// Groups of the row's pixels; no_risk_group for gaps.
    void groups(int y, std::uint8_t* out) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace

struct RiskPicture::State {
    const SourceView& source;
    const EyePicture& picture;
    const PerspectiveCamera camera;
    const RiskNumbers numbers;
    glm::dquat source_from_eye{1, 0, 0, 0};
    FloatImage inverse_planar;
    ByteImage closeness, filled;
    Differences differences;
    FloatImage texture;

    State(const SourceView& source_view, const EyeView& eye, const EyePicture& eye_picture,
          const ReliabilityOptions& options)
        : source(source_view), picture(eye_picture), camera(eye.camera),
          numbers(source_view, eye, eye_picture, options),
          source_from_eye(glm::conjugate(source_view.pose.orientation) * eye.pose.orientation),
          filled(fill_depth(picture.origin)), differences(plain::differences(picture.rgba, numbers.step)),
          texture(mean_around(differences.contrast, numbers.texture_reach)) {
        if (numbers.has_depth())
            inverse_planar = inverse_planar_depth(camera, numbers.depth_m);
        closeness = silhouette_closeness(inverse_planar, picture.origin, numbers.min_step_inverse_m);
    }

    void shape_risks(int y, const float* detail, RiskRow& out) const;
    void flat_risks(const float* detail, RiskRow& out) const;
    bool mirrored(int x, int y) const;
    /// By which an eye that has moved sees the point displaced from where the source does; needs depth.
    float parallax_px(int x, int y) const;
};

/// Without depth nothing is known of the surface: it is taken to face the eye, a metre away.
void RiskPicture::State::flat_risks(const float* detail, RiskRow& out) const {
    const float doublings = std::log2(numbers.density);
    const float parallax = log_of(numbers.focal_px * numbers.baseline_m);
    for (int x = 0; x < out.width; ++x) {
        out.of(Risk::blur)[x] = detail[x] * std::clamp(-doublings, 0.0f, max_halvings);
        out.of(Risk::minification)[x] = detail[x] * std::clamp(doublings, 0.0f, max_halvings);
        out.of(Risk::grazing)[x] = 0;
        out.of(Risk::parallax)[x] = parallax;
    }
}

void RiskPicture::State::shape_risks(int y, const float* detail, RiskRow& out) const {
    const int width = out.width, height = inverse_planar.height();
    const glm::vec3 centre = numbers.centre;
    const float focal_px = numbers.focal_px, density = numbers.density;
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
        const float cosine2 = q[x] * q[x] / (n2 * length2 + min_length2);
        const float inverse_r = q[x] / std::sqrt(length2);
        // Of the point over its distance from the eye, so that misses need no case of their own.
        const float sx = a / std::sqrt(length2) - centre.x * inverse_r;
        const float sy = b / std::sqrt(length2) - centre.y * inverse_r;
        const float sz = -1 / std::sqrt(length2) - centre.z * inverse_r;
        const float nearer2 = 1 / std::max(sx * sx + sy * sy + sz * sz, min_distance2);
        const float facing = std::abs(1 - nx * centre.x - ny * centre.y - nz * centre.z);
        // Density of the source's samples on the surface over that of the eye's, squared.
        const float size2 = density * density / (length2 * std::sqrt(length2)) * nearer2 * std::sqrt(nearer2) *
                            std::max(facing, min_facing);
        const float doublings = 0.5f * fast_log2(size2);
        const float halvings_of_cosine = q[x] > 0 ? -0.5f * fast_log2(std::max(cosine2, min_cosine2)) : 0.0f;
        // Towards a sphere's poles its columns draw together, its rows do not.
        const float sine = numbers.pole.x * sx + numbers.pole.y * sy + numbers.pole.z * sz;
        const float closer = -0.5f * fast_log2(std::max(1 - sine * sine * nearer2, min_cosine2));
        blur[x] = detail[x] * 0.5f *
                  (std::clamp(-doublings, 0.0f, max_halvings) + std::clamp(-doublings - closer, 0.0f, max_halvings));
        minification[x] = detail[x] * std::clamp(doublings, 0.0f, max_halvings);
        grazing[x] = detail[x] * std::clamp(halvings_of_cosine, 0.0f, max_halvings);
        parallax[x] = log_of(parallax_px(x, y));
    }
}

float RiskPicture::State::parallax_px(int x, int y) const {
    const float inverse_focal = 1 / numbers.focal_px;
    const float a = (float(x) + 0.5f - 0.5f * float(camera.width)) * inverse_focal;
    const float b = (0.5f * float(camera.height) - float(y) - 0.5f) * inverse_focal;
    return numbers.focal_px * numbers.baseline_m * inverse_planar.pixel(x, y)[0] / std::sqrt(1 + a * a + b * b);
}

/// Whether the nearest sample of where the source shows what the eye sees is of a mirror.
bool RiskPicture::State::mirrored(int x, int y) const {
    const glm::dvec3 centre(numbers.centre.x, numbers.centre.y, numbers.centre.z);
    glm::dvec3 towards = camera.direction(x + 0.5, y + 0.5);
    towards /= std::max(-towards.z, 1e-9);
    const glm::dvec2 at =
        pixel_of(source.camera, source_from_eye * (towards - double(inverse_planar.pixel(x, y)[0]) * centre));
    if (!(at.x >= 0 && at.y >= 0 && at.x <= source.specular.width && at.y <= source.specular.height))
        return false;
    const int column = std::min(int(at.x), source.specular.width - 1);
    const int row = std::min(int(at.y), source.specular.height - 1);
    return specular_sample(source, column, row).specular;
}

RiskPicture::RiskPicture(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                         const ReliabilityOptions& options)
    : state_(std::make_unique<State>(source, eye, picture, options)) {}
RiskPicture::~RiskPicture() = default;

void RiskPicture::row(int y, RiskRow& out) const {
    const State& s = *state_;
    const std::uint8_t* difference = s.differences.contrast.pixel(0, y);
    const std::uint8_t* bend = s.differences.detail.pixel(0, y);
    const float* texture = s.texture.pixel(0, y);
    float* detail = out.of(Risk::detail);
    for (int x = 0; x < out.width; ++x) {
        out.of(Risk::contrast)[x] = log_of(0.5f * float(difference[x]));
        out.of(Risk::texture)[x] = log_of(0.5f * texture[x]);
        detail[x] = log_of(0.5f * float(bend[x]));
    }
    if (s.numbers.has_depth())
        s.shape_risks(y, detail, out);
    else
        s.flat_risks(detail, out);
    const std::uint8_t* closeness = s.closeness.pixel(0, y);
    const std::uint8_t* filled = s.filled.pixel(0, y);
    const std::uint8_t* rgba = s.picture.rgba.pixel(0, y);
    std::vector<std::uint8_t> group(std::size_t(out.width));
    groups(y, group.data());
    for (int x = 0; x < out.width; ++x) {
        const bool mirrored = group[std::size_t(x)] == std::uint8_t(RiskGroup::mirrored);
        out.of(Risk::silhouette_0)[x] = closeness[x] >= 3 ? 1.0f : 0.0f;
        out.of(Risk::silhouette_1)[x] = closeness[x] >= 2 ? 1.0f : 0.0f;
        out.of(Risk::silhouette_2)[x] = closeness[x] >= 1 ? 1.0f : 0.0f;
        out.of(Risk::specular)[x] =
            mirrored ? log_of(0.5f * float(difference[x]) * std::min(1.0f, s.parallax_px(x, y))) : 0.0f;
        out.of(Risk::depth_error)[x] = log_of(s.numbers.depth_error_px * float(difference[x]));
        out.of(Risk::outside)[x] = s.numbers.outside;
        out.of(Risk::fill_depth)[x] = log_of(float(filled[x]));
        out.of(Risk::brightness)[x] = float(std::max({rgba[4 * x], rgba[4 * x + 1], rgba[4 * x + 2]})) * (1 / 255.0f);
    }
}

void RiskPicture::groups(int y, std::uint8_t* out) const {
    const std::uint8_t* origin = state_->picture.origin.pixel(0, y);
    const RiskNumbers& n = state_->numbers;
    for (int x = 0; x < state_->camera.width; ++x) {
        const bool mirrored = n.mirrors && PixelOrigin(origin[x]) == PixelOrigin::source && state_->mirrored(x, y);
        out[x] = PixelOrigin(origin[x]) == PixelOrigin::gap
                     ? no_risk_group
                     : std::uint8_t(risk_group(PixelOrigin(origin[x]), n.known, mirrored));
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

ByteImage reliability_groups(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options) {
    const RiskPicture risks(source, eye, picture, options);
    ByteImage groups(picture.origin.width(), picture.origin.height(), 1);
    for (int y = 0; y < groups.height(); ++y)
        risks.groups(y, groups.pixel(0, y));
    return groups;
}

/// The calibration table covers sums from 0 to its last entry; beyond that it stays.
float reliability_of(RiskGroup group, const std::array<float, risk_count>& risks) {
    const reliability_model::Group& weighted = reliability_model::groups[std::size_t(group)];
    float sum = 0;
    for (std::size_t k = 0; k < risks.size(); ++k)
        sum += weighted.weights[k] * risks[k];
    const auto entry = int(std::min(sum * reliability_model::entries_per_unit, float(weighted.share_255.size() - 1)));
    return float(weighted.share_255[std::size_t(entry)]) * (1 / 255.0f);
}

void estimate_reliability(const SourceView& source, const EyeView& eye, EyePicture& picture,
                          const ReliabilityOptions& options) {
    const FloatImage risks = plain::reliability_risks(source, eye, picture, options);
    const ByteImage groups = plain::reliability_groups(source, eye, picture, options);
    picture.reliability = ByteImage(risks.width(), risks.height(), 1);
    std::array<float, risk_count> here{};
    for (int y = 0; y < risks.height(); ++y)
        for (int x = 0; x < risks.width(); ++x) {
            std::copy_n(risks.pixel(x, y), risk_count, here.begin());
            const std::uint8_t group = *groups.pixel(x, y);
            std::uint8_t& out = *picture.reliability.pixel(x, y);
            float share = group == no_risk_group ? 0 : reliability_of(RiskGroup(group), here);
            if (same_view(source, eye) && *picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::source))
                share = 1;
            const float loss = loss_at(options.visible_loss.value_or(VisibleLoss()), here[std::size_t(Risk::texture)]);
            out = std::uint8_t(std::lround(255 * share * (1 - loss) * (1 - 0.3f * loss)));
        }
}

}  // namespace equistream::plain
