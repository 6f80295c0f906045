#include "config.h"

#include <equistream/colour.h>

namespace equistream {

namespace {

constexpr const char* display_name = "sRGB - Display";

ocio::ConstCPUProcessorRcPtr make_processor(const ocio::Config& config, const std::string& view,
                                            ocio::TransformDirection direction) {
    return config.getProcessor(display_view(scene_space, display_name, view, direction))
        ->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
}

}  // namespace

struct DisplayTransform::Processors {
    ocio::ConstCPUProcessorRcPtr to_display;
    ocio::ConstCPUProcessorRcPtr to_linear;
};

DisplayTransform::DisplayTransform(const std::string& view) : processors_(std::make_unique<Processors>()) {
    const auto config = load_bundled_config();
    check_view(*config, display_name, view);
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
        [=](float value) { return finite_or_clamped(factor * value, -max_radiance, max_radiance); },
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
