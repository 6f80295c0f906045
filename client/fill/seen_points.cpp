#include "seen_points.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream {

void SeenPoints::look(const EyeView& eye, const EyePicture& picture, const Gaps& gaps) {
    const int width = picture.origin.width();
    const int height = picture.origin.height();
    if (inverse_planar_.width() != width || inverse_planar_.height() != height)
        inverse_planar_ = FloatImage(width, height, 1);
    const bool own = eye.depth_m.data == nullptr && !picture.depth_m.empty();
    const ImageView<const float> depth_m = own ? picture.depth_m.view() : eye.depth_m;
    const auto look_at = [&](int y, int begin, int end) {
        begin = std::max(begin, 0);
        end = std::min(end, width);
        float* inverse = inverse_planar_.pixel(0, y);
        if (depth_m.data == nullptr)
            return std::fill(inverse + begin, inverse + end, std::numeric_limits<float>::quiet_NaN());
        const float* depth = depth_m.row(y);
        for (int x = begin; x < end; ++x)
            inverse[x] = depth[x] > 0 ? radial_over_planar(eye.camera, x, y) / depth[x]
                                      : std::numeric_limits<float>::quiet_NaN();
    };
    // Each task writes rows of its own, whosever neighbours their pixels are.
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const tbb::blocked_range<int>& rows) {
        for (const GapSpan& span : gaps.rows(rows.begin() - 1, rows.end() + 1)) {
            if (span.y >= rows.begin() && span.y < rows.end())
                look_at(span.y, span.begin - 1, span.end + 1);
            if (span.y > rows.begin())
                look_at(span.y - 1, span.begin, span.end);
            if (span.y + 1 < rows.end())
                look_at(span.y + 1, span.begin, span.end);
        }
    });
}

}  // namespace equistream
