#pragma once
/// From a variant's name to its types, for the variants that this build was asked for (EQUISTREAM_SCALAR_RGB and so
/// on). The monochrome ones are left out: frames have colours.
#include <mitsuba/core/spectrum.h>
#include <mitsuba/mitsuba.h>

#include <stdexcept>
#include <string>
#include <string_view>

namespace equistream::mitsuba_host {

template <typename FloatType, typename SpectrumType>
struct Variant {
    using Float = FloatType;
    using Spectrum = SpectrumType;
};

/// Names this build can render with, the first ones first.
std::string known_variants();

/// Calls `function(Variant<...>())`.
template <typename Function>
auto invoke_variant(std::string_view name, Function function) {
    using mitsuba::Color;
    using mitsuba::MuellerMatrix;
    using Llvm [[maybe_unused]] = drjit::DiffArray<JitBackend::LLVM, float>;
    using Cuda [[maybe_unused]] = drjit::DiffArray<JitBackend::CUDA, float>;
#if defined(EQUISTREAM_LLVM_AD_RGB)
    if (name == "llvm_ad_rgb")
        return function(Variant<Llvm, Color<Llvm, 3>>());
#endif
#if defined(EQUISTREAM_LLVM_AD_SPECTRAL)
    if (name == "llvm_ad_spectral")
        return function(Variant<Llvm, mitsuba::Spectrum<Llvm, 4>>());
#endif
#if defined(EQUISTREAM_LLVM_AD_SPECTRAL_POLARIZED)
    if (name == "llvm_ad_spectral_polarized")
        return function(Variant<Llvm, MuellerMatrix<mitsuba::Spectrum<Llvm, 4>>>());
#endif
#if defined(EQUISTREAM_SCALAR_SPECTRAL)
    if (name == "scalar_spectral")
        return function(Variant<float, mitsuba::Spectrum<float, 4>>());
#endif
#if defined(EQUISTREAM_SCALAR_SPECTRAL_POLARIZED)
    if (name == "scalar_spectral_polarized")
        return function(Variant<float, MuellerMatrix<mitsuba::Spectrum<float, 4>>>());
#endif
#if defined(EQUISTREAM_CUDA_AD_RGB)
    if (name == "cuda_ad_rgb")
        return function(Variant<Cuda, Color<Cuda, 3>>());
#endif
#if defined(EQUISTREAM_CUDA_AD_SPECTRAL)
    if (name == "cuda_ad_spectral")
        return function(Variant<Cuda, mitsuba::Spectrum<Cuda, 4>>());
#endif
#if defined(EQUISTREAM_CUDA_AD_SPECTRAL_POLARIZED)
    if (name == "cuda_ad_spectral_polarized")
        return function(Variant<Cuda, MuellerMatrix<mitsuba::Spectrum<Cuda, 4>>>());
#endif
    if (name != "scalar_rgb")
        throw std::logic_error("no such variant: " + std::string(name));
    return function(Variant<float, Color<float, 3>>());
}

}  // namespace equistream::mitsuba_host
