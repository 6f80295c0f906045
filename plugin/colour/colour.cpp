#include "config.h"

#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

namespace equistream {

namespace {

constexpr const char* default_display = "sRGB - Display";

ocio::ConstCPUProcessorRcPtr make_processor(const ocio::Config& config, const std::string& view,
                                            ocio::TransformDirection direction) {
    return config.getProcessor(display_view(scene_space, default_display, view, direction))
        ->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
}

FloatImage exposed(ImageView<const float> linear, const ocio::CPUProcessor& processor, double exposure) {
    check_exposure(exposure);
    const auto factor = static_cast<float>(exposure);
    return transformed(
        linear, processor, [=](float value) { return finite_or_clamped(factor * value, -max_radiance, max_radiance); },
        within_display);
}

constexpr const char* pq_display = "Rec.2100-PQ - Display";
/// What that display, and each whose encoding is HDR video, has for 1, nits.
constexpr double pq_unit_nits = 100;

/// From 1 being our white to 1 being what HDR displays have for it.
ocio::MatrixTransformRcPtr white_to_unit() {
    constexpr double gain = pq_white_nits / pq_unit_nits;
    constexpr std::array<double, 4> gains = {gain, gain, gain, 1};
    std::array<double, 16> matrix;
    std::array<double, 4> offset;
    ocio::MatrixTransform::Scale(matrix.data(), offset.data(), gains.data());
    auto scale = ocio::MatrixTransform::Create();
    scale->setMatrix(matrix.data());
    return scale;
}

/// Between scene-referred linear Rec.709, 1 being pq_white_nits, and PQ.
ocio::GroupTransformRcPtr pq_of_linear(ocio::TransformDirection direction) {
    auto group = ocio::GroupTransform::Create();
    group->appendTransform(white_to_unit());
    group->appendTransform(display_view(scene_space, pq_display, default_view, ocio::TRANSFORM_DIR_FORWARD));
    group->setDirection(direction);
    return group;
}

/// Whether light is shown as it is, up to what an HDR display can: white must be as bright there as in the stream.
/// Other views of such displays say themselves how bright it is.
bool keeps_light(const ocio::Config& config, const HdrDisplaySettings& settings) {
    const char *display = settings.display.c_str(), *view = settings.view.c_str();
    const std::string named = config.getDisplayViewColorSpaceName(display, view);
    const auto space = config.getColorSpace(named == ocio::OCIO_VIEW_USE_DISPLAY_NAME ? display : named.c_str());
    return space && std::string_view(space->getEncoding()) == "hdr-video" &&
           std::string_view(config.getDisplayViewTransformName(display, view)) == default_view;
}

/// What a file of a config leaves open stays as the file has it: the exposure alone is to be set.
ocio::ConstTransformRcPtr with_all_fixed(const ocio::ConstProcessorRcPtr& processor) {
    const ocio::GroupTransformRcPtr group = processor->createGroupTransform();
    for (int i = 0; i < group->getNumTransforms(); ++i) {
        const ocio::TransformRcPtr& one = group->getTransform(i);
        if (const auto contrast = OCIO_DYNAMIC_POINTER_CAST<ocio::ExposureContrastTransform>(one)) {
            contrast->makeExposureNonDynamic();
            contrast->makeContrastNonDynamic();
            contrast->makeGammaNonDynamic();
        } else if (const auto primary = OCIO_DYNAMIC_POINTER_CAST<ocio::GradingPrimaryTransform>(one)) {
            primary->makeNonDynamic();
        } else if (const auto curve = OCIO_DYNAMIC_POINTER_CAST<ocio::GradingRGBCurveTransform>(one)) {
            curve->makeNonDynamic();
        } else if (const auto tone = OCIO_DYNAMIC_POINTER_CAST<ocio::GradingToneTransform>(one)) {
            tone->makeNonDynamic();
        }
    }
    return group;
}

/// OpenColorIO's messages may have several lines.
std::string first_line(const char* text) {
    return std::string(text, std::strcspn(text, "\n"));
}

ocio::ConstConfigRcPtr load_config(const std::string& file) {
    try {
        return ocio::Config::CreateFromFile(file.c_str());
    } catch (const ocio::Exception& error) {
        throw InputError(expected_found(file, "an OpenColorIO config", first_line(error.what())));
    }
}

std::vector<float> copied(const float* values, std::size_t count) {
    return {values, values + count};
}

std::vector<ShaderTable> tables_of(const ocio::GpuShaderDesc& desc) {
    std::vector<ShaderTable> tables;
    for (unsigned i = 0; i < desc.getNumTextures(); ++i) {
        const char *texture = nullptr, *sampler = nullptr;
        unsigned width = 0, height = 0;
        ocio::GpuShaderDesc::TextureType kind{};
        ocio::Interpolation interpolation{};
        desc.getTexture(i, texture, sampler, width, height, kind, interpolation);
        const float* values = nullptr;
        desc.getTextureValues(i, values);
        const int channels = kind == ocio::GpuShaderDesc::TEXTURE_RED_CHANNEL ? 1 : 3;
        // One row is a one-dimensional sampler.
        tables.push_back({sampler, int(width), height > 1 ? int(height) : 0, 0, channels,
                          interpolation != ocio::INTERP_NEAREST,
                          copied(values, std::size_t(width) * height * std::size_t(channels))});
    }
    for (unsigned i = 0; i < desc.getNum3DTextures(); ++i) {
        const char *texture = nullptr, *sampler = nullptr;
        unsigned edge = 0;
        ocio::Interpolation interpolation{};
        desc.get3DTexture(i, texture, sampler, edge, interpolation);
        const float* values = nullptr;
        desc.get3DTextureValues(i, values);
        const int side = int(edge);
        // Tetrahedral interpolation is the shader's own work, between texels.
        const bool linear = interpolation != ocio::INTERP_NEAREST && interpolation != ocio::INTERP_TETRAHEDRAL;
        tables.push_back({sampler, side, side, side, 3, linear, copied(values, std::size_t(3) * edge * edge * edge)});
    }
    return tables;
}

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

struct DisplayTransform::Processors {
    ocio::ConstCPUProcessorRcPtr to_display;
    ocio::ConstCPUProcessorRcPtr to_linear;
};

DisplayTransform::DisplayTransform(const std::string& view) : processors_(std::make_unique<Processors>()) {
    const PlainStreams plain;
    const auto config = load_bundled_config();
    check_view(*config, default_display, view);
    processors_->to_display = make_processor(*config, view, ocio::TRANSFORM_DIR_FORWARD);
    processors_->to_linear = make_processor(*config, view, ocio::TRANSFORM_DIR_INVERSE);
}

DisplayTransform::~DisplayTransform() = default;
DisplayTransform::DisplayTransform(DisplayTransform&&) noexcept = default;

FloatImage DisplayTransform::to_display(ImageView<const float> linear, double exposure) const {
    return exposed(linear, *processors_->to_display, exposure);
}

FloatImage DisplayTransform::to_linear(ImageView<const float> display, double exposure) const {
    check_exposure(exposure);
    const auto factor = static_cast<float>(1 / exposure);
    return transformed(display, *processors_->to_linear, within_display, [=](float value) { return factor * value; });
}

struct PqEncoding::Processor {
    ocio::ConstCPUProcessorRcPtr cpu;
};

PqEncoding::PqEncoding() : processor_(std::make_unique<Processor>()) {
    const PlainStreams plain;
    processor_->cpu = load_bundled_config()
                          ->getProcessor(pq_of_linear(ocio::TRANSFORM_DIR_FORWARD))
                          ->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
}

PqEncoding::~PqEncoding() = default;

FloatImage PqEncoding::encode(ImageView<const float> linear, double exposure) const {
    return exposed(linear, *processor_->cpu, exposure);
}

/// Each leads from where the one before ended.
struct HdrDisplay::Transforms {
    ocio::ConstTransformRcPtr to_scene;   ///< PQ to linear Rec.709
    ocio::ConstTransformRcPtr to_config;  ///< null: it has that space
    ocio::ConstTransformRcPtr brighten;   ///< null: the view says itself how bright white is
    ocio::ConstTransformRcPtr to_display;
    ocio::ConstCPUProcessorRcPtr cpu;

    ocio::ConstProcessorRcPtr with_exposure(double stops, bool dynamic) const {
        auto exposure = ocio::ExposureContrastTransform::Create();
        exposure->setStyle(ocio::EXPOSURE_CONTRAST_LINEAR);
        exposure->setExposure(stops);
        if (dynamic)
            exposure->makeExposureDynamic();
        auto group = ocio::GroupTransform::Create();
        group->appendTransform(to_scene->createEditableCopy());
        group->appendTransform(exposure);
        if (to_config)
            group->appendTransform(to_config->createEditableCopy());
        if (brighten)
            group->appendTransform(brighten->createEditableCopy());
        group->appendTransform(to_display->createEditableCopy());
        return ocio::Config::CreateRaw()->getProcessor(group);
    }
};

HdrDisplay::HdrDisplay(const HdrDisplaySettings& settings)
    : settings_(settings), transforms_(std::make_unique<Transforms>()) {
    if (!(std::abs(settings.exposure_stops) <= max_exposure_stops))
        throw InputError(expected_found("exposure", "-20 to 20 stops", in_words(settings.exposure_stops)));
    const PlainStreams plain;
    const ocio::ConstConfigRcPtr bundled = load_bundled_config();
    const bool own = settings.config.empty();
    const ocio::ConstConfigRcPtr config = own ? bundled : load_config(settings.config);
    if (settings_.display.empty())
        settings_.display = own ? default_display : config->getDefaultDisplay();
    check_name("display", settings_.display, config->getNumDisplays(), [&](int i) { return config->getDisplay(i); });
    if (settings_.view.empty())
        settings_.view = own && settings_.display == default_display
                             ? default_view
                             : config->getDefaultView(settings_.display.c_str());
    check_view(*config, settings_.display, settings_.view);
    try {
        transforms_->to_scene =
            bundled->getProcessor(pq_of_linear(ocio::TRANSFORM_DIR_INVERSE))->createGroupTransform();
        if (!own)
            transforms_->to_config =
                ocio::Config::GetProcessorFromConfigs(bundled, scene_space, config, ocio::ROLE_SCENE_LINEAR)
                    ->createGroupTransform();
        const auto to_display = display_view(own ? scene_space : ocio::ROLE_SCENE_LINEAR, settings_.display,
                                             settings_.view, ocio::TRANSFORM_DIR_FORWARD);
        transforms_->to_display = with_all_fixed(config->getProcessor(to_display));
        if (keeps_light(*config, settings_))
            transforms_->brighten = white_to_unit();
        transforms_->cpu = transforms_->with_exposure(settings_.exposure_stops, false)
                               ->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS);
    } catch (const ocio::Exception& error) {
        throw InputError(expected_found(own ? "OpenColorIO" : settings.config,
                                        "a config with the roles scene_linear and aces_interchange and a view that "
                                        "can be computed",
                                        first_line(error.what())));
    }
}

HdrDisplay::~HdrDisplay() = default;

FloatImage HdrDisplay::to_display(ImageView<const float> pq) const {
    return transformed(pq, *transforms_->cpu, within_display, within_display);
}

DisplayShader HdrDisplay::shader() const {
    const PlainStreams plain;
    auto desc = ocio::GpuShaderDesc::CreateShaderDesc();
    desc->setLanguage(ocio::GPU_LANGUAGE_GLSL_4_0);
    desc->setFunctionName(DisplayShader::function);
    desc->setResourcePrefix("ocio_");
    transforms_->with_exposure(settings_.exposure_stops, true)
        ->getOptimizedGPUProcessor(ocio::OPTIMIZATION_LOSSLESS)
        ->extractGpuShaderInfo(desc);
    if (desc->getNumUniforms() != 1)
        throw InputError(expected_found(settings_.config.empty() ? "OpenColorIO" : settings_.config,
                                        "a view whose only dynamic property is the exposure",
                                        std::to_string(desc->getNumUniforms() - 1) + " more uniforms"));
    ocio::GpuShaderDesc::UniformData data;
    return {desc->getShaderText(), desc->getUniform(0, data), tables_of(*desc)};
}

ByteImage quantise_8bit(ImageView<const float> display) {
    return converted<std::uint8_t>(display, to_byte);
}

FloatImage widen_8bit(ImageView<const std::uint8_t> display) {
    return converted<float>(display, [](std::uint8_t value) { return static_cast<float>(value) / 255.0f; });
}

}  // namespace equistream
