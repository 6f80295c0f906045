#include "gap_samples.h"

#include <tbb/parallel_for.h>

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

}  // namespace

void append_gap_samples(const DepthSphere& eye, const DepthSphere& centre, std::span<const DepthSphere> auxiliary,
                        const GapRule& rule, GapSamples& samples) {
    const EquirectCamera& camera = eye.camera();
    const int count = (camera.height + rule.stride - 1) / rule.stride;
    const Gaps gaps(eye, centre, auxiliary, rule);
    std::vector<Row> rows(static_cast<std::size_t>(count));
    tbb::parallel_for(0, count, [&](int i) { gaps.look_along(i * rule.stride, rows[static_cast<std::size_t>(i)]); });
    if (samples.first.empty())
        samples.first.push_back(0);
    for (int i = 0; i < count; ++i) {
        const Row& row = rows[static_cast<std::size_t>(i)];
        samples.tried += rule.weight *
                         equirect_pixel_solid_angle(i * rule.stride, camera.width, camera.height, camera.range) *
                         ((camera.width + rule.stride - 1) / rule.stride);
        samples.weight.insert(samples.weight.end(), row.weight.begin(), row.weight.end());
        samples.blocks.insert(samples.blocks.end(), row.blocks.begin(), row.blocks.end());
        for (const std::uint32_t blocks : row.count)
            samples.first.push_back(samples.first.back() + blocks);
    }
}

}  // namespace equistream
