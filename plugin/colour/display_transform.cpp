#include "bundled_config.h"

#include <equistream/colour.h>
#include <equistream/error.h>

#include <OpenColorIO/OpenColorIO.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace ocio = OCIO_NAMESPACE;

namespace equistream {

namespace {

constexpr const char* scene_space = "Linear Rec.709 (sRGB)";
constexpr const char* display_name = "sRGB - Display";

/// Radiance beyond this (and infinities) is white in every view; the bound keeps infinities out of the matrices.
constexpr float largest_radiance = 65504.0f;

/// Enough pixels for OpenColorIO's per-call cost to vanish, few enough to stay in a core's cache.
constexpr int pixels_per_block = 1 << 14;

ocio::ConstConfigRcPtr load_bundled_config() {
    std::istringstream text(bundled_config_text);
    return ocio::Config::CreateFromStream(text);
}

void check_view(const ocio::Config& config, const std::string& view) {
    std::string accepted;
    for (int i = 0; i < config.getNumViews(display_name); ++i) {
        const std::string name = config.getView(display_name, i);
        if (name == view)
            return;
        accepted += (accepted.empty() ? "" : ", ") + ("\"" + name + "\"");
    }
    throw InputError(expected_found("view", "one of " + accepted, "\"" + view + "\""));
}

ocio::ConstCPUProcessorRcPtr make_processor(const ocio::Config& config, const std::string& view,
                                            ocio::TransformDirection direction) {
    auto transform = ocio::DisplayViewTransform::Create();
    transform->setSrc(scene_space);
    transform->setDisplay(display_name);
    transform->setView(view.c_str());
    transform->setDirection(direction);
    return config.getProcessor(transform)->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
}

void check_exposure(double exposure) {
    if (!(exposure > 0) || !std::isfinite(exposure))
        throw InputError(expected_found("exposure", "a positive number", std::to_string(exposure)));
}

float finite_or_clamped(float value, float low, float high) {
    return std::isnan(value) ? 0.0f : std::clamp(value, low, high);
}

/// Runs `prepare` on each sample, the processor on each block of rows, then `conclude` on each sample.
template <typename Prepare, typename Conclude>
FloatImage transformed(ImageView<const float> source, const ocio::CPUProcessor& processor, const Prepare& prepare,
                       const Conclude& conclude) {
    assert(source.channels == 3 || source.channels == 4);
    FloatImage result(source.width, source.height, 3);
    if (result.empty())
        return result;
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

}  // namespace

struct DisplayTransform::Processors {
    ocio::ConstCPUProcessorRcPtr to_display;
    ocio::ConstCPUProcessorRcPtr to_linear;
};

DisplayTransform::DisplayTransform(const std::string& view) : processors_(std::make_unique<Processors>()) {
    const auto config = load_bundled_config();
    check_view(*config, view);
    processors_->to_display = make_processor(*config, view, ocio::TRANSFORM_DIR_FORWARD);
    processors_->to_linear = make_processor(*config, view, ocio::TRANSFORM_DIR_INVERSE);
}

DisplayTransform::~DisplayTransform() = default;
DisplayTransform::DisplayTransform(DisplayTransform&&) noexcept = default;

FloatImage DisplayTransform::to_display(ImageView<const float> linear, double exposure) const {
    check_exposure(exposure);
    const auto factor = static_cast<float>(exposure);
    return transformed(
        linear, *processors_->to_display,
        [=](float value) { return finite_or_clamped(factor * value, -largest_radiance, largest_radiance); },
        [](float value) { return finite_or_clamped(value, 0, 1); });
}

FloatImage DisplayTransform::to_linear(ImageView<const float> display, double exposure) const {
    check_exposure(exposure);
    const auto factor = static_cast<float>(1 / exposure);
    return transformed(
        display, *processors_->to_linear, [](float value) { return finite_or_clamped(value, 0, 1); },
        [=](float value) { return factor * value; });
}

}  // namespace equistream
