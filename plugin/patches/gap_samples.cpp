#include "gap_samples.h"

#include <equistream/error.h>

#include <tbb/parallel_for.h>

#include <limits>

namespace equistream {
namespace {

/// Samples of one row, so that rows can be done in any order and still be joined in theirs.
struct Row {
    std::vector<float> weight;
    std::vector<std::uint32_t> count;
    std::vector<BlockId> blocks;
};

class Gaps {
public:
    Gaps(const DepthSphere& eye, const DepthSphere& centre, std::span<const DepthSphere> auxiliary, const GapRule& rule)
        : eye_(eye), centre_(centre), auxiliary_(auxiliary), side_(rule.block_side), stride_(rule.stride),
          weight_(rule.weight), block_columns_(static_cast<BlockId>((eye.camera().width + side_ - 1) / side_)),
          block_rows_(static_cast<BlockId>((eye.camera().height + side_ - 1) / side_)),
          centre_agreement_(agreement(centre, rule)) {
        for (const DepthSphere& sphere : auxiliary)
            agreements_.push_back(agreement(sphere, rule));
    }

    void look_along(int y, Row& row) const {
        const EquirectCamera& camera = eye_.camera();
        const auto weight =
            static_cast<float>(weight_ * equirect_pixel_solid_angle(y, camera.width, camera.height, camera.range));
        for (int x = (y / stride_ % 2) * (stride_ / 2); x < camera.width; x += stride_) {
            SurfacePoint point = eye_.point(x, y);
            if (outside(camera.pixel(point.position_m)))
                continue;
            point.plane = eye_.plane(x, y);
            if (centre_.seen(point, centre_agreement_).total() > min_seen_weight)
                continue;
            row.weight.push_back(weight);
            row.count.push_back(append_blocks(point, row.blocks));
        }
    }

private:
    DepthAgreement agreement(const DepthSphere& sphere, const GapRule& rule) const {
        return {static_cast<float>(std::max(rule.box_radius_m, glm::distance(eye_.offset_m(), sphere.offset_m()))),
                static_cast<float>(std::sin(rule.tolerance_rad))};
    }
    /// On a partial range: not the sphere's to show, so no gap of it.
    bool outside(const glm::dvec2& at) const {
        return !(at.x >= 0 && at.x <= eye_.camera().width && at.y >= 0 && at.y <= eye_.camera().height);
    }

    std::uint32_t append_blocks(const SurfacePoint& point, std::vector<BlockId>& blocks) const {
        std::uint32_t count = 0;
        for (std::size_t k = 0; k < auxiliary_.size(); ++k) {
            const SeenTaps taps = auxiliary_[k].seen(point, agreements_[k]);
            if (taps.total() <= min_seen_weight)
                continue;
            // Around a corner the four samples lie in up to four blocks; each that has enough of the weight will do.
            std::array<BlockId, 4> found{};
            std::size_t distinct = 0;
            for (std::size_t t = 0; t < 4; ++t) {
                const BlockId block = id(k, taps.x[t], taps.y[t]);
                float weight = 0;
                for (std::size_t u = 0; u < 4; ++u)
                    weight += id(k, taps.x[u], taps.y[u]) == block ? taps.weight[u] : 0;
                if (weight <= min_seen_weight ||
                    std::find(found.begin(), found.begin() + distinct, block) != found.begin() + distinct)
                    continue;
                found[distinct++] = block;
                blocks.push_back(block);
                ++count;
            }
        }
        return count;
    }
    BlockId id(std::size_t k, int x, int y) const {
        return (static_cast<BlockId>(k) * block_rows_ + static_cast<BlockId>(y / side_)) * block_columns_ +
               static_cast<BlockId>(x / side_);
    }

    const DepthSphere& eye_;
    const DepthSphere& centre_;
    std::span<const DepthSphere> auxiliary_;
    int side_, stride_;
    double weight_;
    BlockId block_columns_, block_rows_;
    DepthAgreement centre_agreement_;
    std::vector<DepthAgreement> agreements_;
};

double inverse(float depth_m) {
    return 1 / std::min<double>(depth_m, far_distance_m);
}

}  // namespace

void append_gap_samples(const DepthSphere& eye, const DepthSphere& centre, std::span<const DepthSphere> auxiliary,
                        const GapRule& rule, GapSamples& samples) {
    const int count = (eye.camera().height + rule.stride - 1) / rule.stride;
    const Gaps gaps(eye, centre, auxiliary, rule);
    std::vector<Row> rows(static_cast<std::size_t>(count));
    tbb::parallel_for(0, count, [&](int i) { gaps.look_along(i * rule.stride, rows[static_cast<std::size_t>(i)]); });
    if (samples.first.empty())
        samples.first.push_back(0);
    std::size_t all = samples.blocks.size();
    for (const Row& row : rows)
        all += row.blocks.size();
    if (all > std::numeric_limits<std::uint32_t>::max())
        throw WorkError("patches: more gaps than can be counted; a smaller sphere has fewer");
    for (const Row& row : rows) {
        samples.weight.insert(samples.weight.end(), row.weight.begin(), row.weight.end());
        samples.blocks.insert(samples.blocks.end(), row.blocks.begin(), row.blocks.end());
        for (const std::uint32_t blocks : row.count)
            samples.first.push_back(samples.first.back() + blocks);
    }
}

DepthSphere::DepthSphere(const EquirectCamera& camera, const glm::dvec3& offset_m)
    : camera_(camera), offset_m_(offset_m), depth_m_(camera.width, camera.height, 1) {
    const LongitudeLatitudeRange& range = camera.range;
    for (int x = 0; x < camera.width; ++x) {
        const double l = range.longitude_min + (x + 0.5) * range.longitude_span() / camera.width;
        longitude_.emplace_back(std::sin(l), std::cos(l));
    }
    for (int y = 0; y < camera.height; ++y) {
        const double p = range.latitude_max - (y + 0.5) * range.latitude_span() / camera.height;
        latitude_.emplace_back(std::sin(p), std::cos(p));
    }
}

int DepthSphere::wrapped_column(int x) const {
    if (!camera_.range.closes())
        return std::clamp(x, 0, camera_.width - 1);
    return x < 0 ? x + camera_.width : x >= camera_.width ? x - camera_.width : x;
}

glm::dvec3 DepthSphere::direction(int x, int y) const {
    const glm::dvec2 l = longitude_[static_cast<std::size_t>(wrapped_column(x))];
    const glm::dvec2 p = latitude_[static_cast<std::size_t>(y)];
    return {p.y * l.x, p.x, -p.y * l.y};
}

SurfacePoint DepthSphere::point(int x, int y) const {
    const double r = std::min<double>(depth_m_.pixel(x, y)[0], far_distance_m);
    return {offset_m_ + r * direction(x, y), glm::dvec3(0), offset_m_};
}

glm::dvec3 DepthSphere::plane(int x, int y) const {
    const double here = inverse(depth_m_.pixel(x, y)[0]);
    if (camera_.height < 2)  // no second row to lay a plane through
        return here * direction(x, y);
    const auto at = [&](int column, int row) { return inverse(depth_m_.pixel(wrapped_column(column), row)[0]); };
    const double left = at(x - 1, y), right = at(x + 1, y);
    const int dx = std::abs(left - here) < std::abs(right - here) ? -1 : 1;
    int dy = y + 1 < camera_.height ? 1 : -1;
    if (y > 0 && y + 1 < camera_.height && std::abs(at(x, y - 1) - here) < std::abs(at(x, y + 1) - here))
        dy = -1;
    // 1/r(q) = m . q through three pixels, by Cramer's rule.
    const glm::dvec3 q0 = direction(x, y), q1 = direction(x + dx, y), q2 = direction(x, y + dy);
    const glm::dvec3 across = glm::cross(q1, q2);
    const double determinant = glm::dot(q0, across);
    if (std::abs(determinant) < 1e-14)
        return q0 * here;
    return (here * across + (dx < 0 ? left : right) * glm::cross(q2, q0) + at(x, y + dy) * glm::cross(q0, q1)) /
           determinant;
}

SeenTaps DepthSphere::seen(const SurfacePoint& point, const DepthAgreement& agreement) const {
    const glm::dvec3 to_point = point.position_m - offset_m_;
    const glm::dvec2 at = camera_.pixel(to_point);
    SeenTaps taps;
    const double at_here = 1 - glm::dot(point.plane, offset_m_ - point.eye_m);
    if (at_here <= 0)  // the surface turns its back to this sphere
        return taps;
    const glm::dvec2 corner = glm::floor(at - 0.5);
    if (!(at.x >= 0 && at.x <= camera_.width && at.y >= 0 && at.y <= camera_.height))
        return taps;
    const glm::dvec2 f = at - 0.5 - corner;
    const float reach = agreement.clearance(static_cast<float>(glm::length(to_point)));
    for (std::size_t k = 0; k < 4; ++k) {
        const int right = static_cast<int>(k & 1), down = static_cast<int>(k >> 1);
        taps.x[k] = wrapped_column(static_cast<int>(corner.x) + right);
        taps.y[k] = std::clamp(static_cast<int>(corner.y) + down, 0, camera_.height - 1);
        const float sample = agreement.clearance(depth_m_.pixel(taps.x[k], taps.y[k])[0]);
        bool same = agreement.same(reach, sample);
        if (!same && point.plane != glm::dvec3(0)) {
            const double inverse_distance = glm::dot(point.plane, direction(taps.x[k], taps.y[k])) / at_here;
            const double predicted =
                inverse_distance > 1 / double{far_distance_m} ? 1 / inverse_distance : far_distance_m;
            same = agreement.between(reach, agreement.clearance(static_cast<float>(predicted)), sample);
        }
        if (same)
            taps.weight[k] = static_cast<float>((right ? f.x : 1 - f.x) * (down ? f.y : 1 - f.y));
    }
    return taps;
}

}  // namespace equistream
