#pragma once
/// OpenColorIO configs, and processors applied to images.
#include <equistream/image.h>

#include <OpenColorIO/OpenColorIO.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <locale>
#include <mutex>
#include <optional>
#include <string>

namespace equistream {

namespace ocio = OCIO_NAMESPACE;

inline constexpr const char* scene_space = "Linear Rec.709 (sRGB)";

/// Radiance beyond this (and infinities) is white in every view; the bound keeps infinities out of the matrices.
inline constexpr float max_radiance = 65504.0f;

/// While it lives, new C++ streams read and write numbers as in the "C" locale: OpenColorIO reads configs and writes
/// shaders by them. Their locale is the whole process's (std::locale::global), so one lives at a time. The locale of C
/// functions stays as it is: OpenColorIO does not mind it.
class PlainStreams {
public:
    PlainStreams();
    ~PlainStreams();
    PlainStreams(const PlainStreams&) = delete;
    PlainStreams& operator=(const PlainStreams&) = delete;

private:
    std::unique_lock<std::mutex> lock_;
    std::optional<std::locale> of_host_;  ///< where it was another
};

/// The text of the one that is compiled in, so that no install path is needed.
const char* bundled_config_text();
ocio::ConstConfigRcPtr load_bundled_config();
/// Throw InputError with the accepted names.
void check_name(const char* what, const std::string& name, int count, const std::function<const char*(int)>& name_at);
void check_view(const ocio::Config& config, const std::string& display, const std::string& view);
ocio::DisplayViewTransformRcPtr display_view(const std::string& from, const std::string& display,
                                             const std::string& view, ocio::TransformDirection direction);
/// Throws InputError.
void check_exposure(double exposure);

inline float finite_or_clamped(float value, float low, float high) {
    return std::isnan(value) ? 0.0f : std::clamp(value, low, high);
}

/// What displays and PQ take.
inline float within_display(float value) {
    return finite_or_clamped(value, 0, 1);
}

/// Runs `prepare` on each sample, the processor on each block of rows, then `conclude` on each sample.
template <typename Prepare, typename Conclude>
FloatImage transformed(ImageView<const float> source, const ocio::CPUProcessor& processor, const Prepare& prepare,
                       const Conclude& conclude) {
    assert(source.channels == 3 || source.channels == 4);
    FloatImage result(source.width, source.height, 3);
    if (result.empty())
        return result;
    // Enough pixels for OpenColorIO's per-call cost to vanish, few enough to stay in a core's cache.
    constexpr int pixels_per_block = 1 << 14;
    const auto target = result.view();
    const int rows_per_block = std::max(1, pixels_per_block / source.width);
    const auto run = [&](const tbb::blocked_range<int>& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y) {
            const float* from = source.row(y);
            float* to = target.row(y);
            for (int x = 0; x < source.width; ++x, from += source.channels, to += 3)
                std::transform(from, from + 3, to, prepare);
        }
        float* first = target.row(rows.begin());
        ocio::PackedImageDesc block(first, source.width, static_cast<long>(rows.size()), 3);
        processor.apply(block);
        std::transform(first, first + static_cast<std::ptrdiff_t>(rows.size()) * target.row_stride, first, conclude);
    };
    tbb::parallel_for(tbb::blocked_range<int>(0, source.height, static_cast<std::size_t>(rows_per_block)), run,
                      tbb::simple_partitioner());
    return result;
}

}  // namespace equistream
