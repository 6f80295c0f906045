#include <equistream/half_depth.h>

#include <tbb/parallel_for.h>

#include <cassert>
#include <cmath>

namespace equistream {

FloatImage halve_depth(ImageView<const float> depth_m) {
    assert(depth_m.channels == 1 && depth_m.width % 2 == 0 && depth_m.height % 2 == 0);
    FloatImage half_m(depth_m.width / 2, depth_m.height / 2, 1);
    tbb::parallel_for(0, half_m.height(), [&](int y) {
        const float* upper = depth_m.row(2 * y);
        const float* lower = depth_m.row(2 * y + 1);
        float* half = half_m.pixel(0, y);
        // fmin passes NaN by.
        for (int x = 0; x < half_m.width(); ++x)
            half[x] = std::fmin(std::fmin(upper[2 * x], upper[2 * x + 1]), std::fmin(lower[2 * x], lower[2 * x + 1]));
    });
    return half_m;
}

FloatImage double_depth(ImageView<const float> half_m) {
    assert(half_m.channels == 1);
    FloatImage depth_m(half_m.width * 2, half_m.height * 2, 1);
    tbb::parallel_for(0, half_m.height, [&](int y) {
        const float* half = half_m.row(y);
        for (int row = 2 * y; row < 2 * y + 2; ++row)
            for (int x = 0; x < half_m.width; ++x)
                depth_m.pixel(2 * x, row)[0] = depth_m.pixel(2 * x, row)[1] = half[x];
    });
    return depth_m;
}

}  // namespace equistream
