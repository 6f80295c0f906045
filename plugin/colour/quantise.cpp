#include <equistream/colour.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

std::uint8_t to_byte(float value) {
    // max(0, NaN) is 0 in this order of arguments.
    const float clamped = std::min(1.0f, std::max(0.0f, value));
    return static_cast<std::uint8_t>(std::floor(255.0f * clamped + 0.5f));
}

template <typename Out, typename In, typename Convert>
Image<Out> converted(ImageView<const In> source, const Convert& convert) {
    Image<Out> result(source.width, source.height, source.channels);
    const auto target = result.view();
    tbb::parallel_for(tbb::blocked_range<int>(0, source.height, 16), [&](const auto& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const In* from = source.row(y);
            std::transform(from, from + target.row_stride, target.row(y), convert);
        }
    });
    return result;
}

}  // namespace

ByteImage quantise_8bit(ImageView<const float> display) {
    return converted<std::uint8_t>(display, to_byte);
}

FloatImage widen_8bit(ImageView<const std::uint8_t> display) {
    return converted<float>(display, [](std::uint8_t value) { return static_cast<float>(value) / 255.0f; });
}

}  // namespace equistream
