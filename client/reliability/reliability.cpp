#include "coefficients.h"
#include "risks.h"

#include <equistream_client/engine.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace equistream {

namespace {

using reliability_model::Group;
using reliability_model::groups;

/// The calibration table covers sums from 0 to its last entry; beyond that it stays.
inline std::uint8_t look_up(const Group& group, float sum) {
    const auto entry = int(std::min(sum * reliability_model::entries_per_unit, float(group.share_255.size() - 1)));
    return group.share_255[std::size_t(entry)];
}

struct WeightedRows {
    explicit WeightedRows(int width) : risks(width), sums(std::size_t(width)) {}
    RiskRow risks;
    std::vector<float> sums;

    void add_up(const Group& group) {
        std::ranges::fill(sums, 0.0f);
        for (int k = 0; k < risk_count; ++k) {
            const float weight = group.weights[std::size_t(k)];
            const float* risk = risks.of(Risk(k));
            if (weight > 0)
                for (std::size_t x = 0; x < sums.size(); ++x)
                    sums[x] += weight * risk[x];
        }
    }
};

bool same_view(const SourceView& source, const EyeView& eye) {
    return same_camera(source.camera, eye.camera) && same_pose(source.pose, eye.pose);
}

}  // namespace

RiskGroup risk_group(PixelOrigin origin, bool has_depth) {
    switch (origin) {
    case PixelOrigin::source:
        return has_depth ? RiskGroup::source : RiskGroup::turned;
    case PixelOrigin::earlier:
    case PixelOrigin::patches:
    case PixelOrigin::hidden:
        return RiskGroup::source;
    case PixelOrigin::small:
        return RiskGroup::small;
    default:
        return RiskGroup::guessed;
    }
}

float reliability_of(RiskGroup group, const std::array<float, risk_count>& risks) {
    const Group& weighted = groups[std::size_t(group)];
    float sum = 0;
    for (std::size_t k = 0; k < risks.size(); ++k)
        sum += weighted.weights[k] * risks[k];
    return float(look_up(weighted, sum)) * (1 / 255.0f);
}

void estimate_reliability(const SourceView& source, const EyeView& eye, EyePicture& picture,
                          const ReliabilityOptions& options) {
    const int width = picture.origin.width(), height = picture.origin.height();
    picture.reliability = ByteImage(width, height, 1);
    const bool untouched = same_view(source, eye);
    const RiskPicture risks(source, eye, picture, options);
    const bool moved_blindly = !risks.has_depth() && !same_position(source.pose, eye.pose);
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
        WeightedRows weighted(width);
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const std::uint8_t* origin = picture.origin.pixel(0, y);
            std::uint8_t* out = picture.reliability.pixel(0, y);
            risks.row(y, weighted.risks);
            std::array<bool, pixel_origin_count> there{};
            for (int x = 0; x < width; ++x)
                there[std::min<std::size_t>(origin[x], there.size() - 1)] = true;
            for (int group = 0; group < risk_group_count; ++group) {
                std::array<bool, pixel_origin_count> takes{};
                bool any = false;
                for (std::size_t o = 1; o < takes.size(); ++o) {
                    takes[o] = there[o] && risk_group(PixelOrigin(o), !moved_blindly) == RiskGroup(group);
                    any |= takes[o];
                }
                if (!any)
                    continue;
                const Group& model = groups[std::size_t(group)];
                weighted.add_up(model);
                for (int x = 0; x < width; ++x)
                    if (takes[origin[x]])
                        out[x] = look_up(model, weighted.sums[std::size_t(x)]);
            }
            if (untouched)
                for (int x = 0; x < width; ++x)
                    if (origin[x] == std::uint8_t(PixelOrigin::source))
                        out[x] = 255;
        }
    });
}

}  // namespace equistream
