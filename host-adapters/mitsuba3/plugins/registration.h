#pragma once
/// How a plugin tells Mitsuba of its variants: those that CMake asked for (EQUISTREAM_SCALAR_RGB and so on). They may
/// be compiled in one file or in several; registration.cpp lists what all of them registered.
#include "version_check.h"

#include <mitsuba/core/object.h>
#include <mitsuba/core/properties.h>
#include <mitsuba/core/spectrum.h>
#include <mitsuba/core/util.h>
#include <mitsuba/mitsuba.h>

namespace equistream::mitsuba_host {

/// Mitsuba swallows what init_plugin throws and then says that the plugin is unknown, so the release is looked at when
/// an object is made.
template <typename Plugin>
mitsuba::ref<mitsuba::Object> make_object(void*, const mitsuba::Properties& properties) {
    require_release(std::string(properties.plugin_name()), mitsuba::util::info_build(1), MI_VERSION);
    return new Plugin(properties);
}

template <typename Plugin>
void register_variant(std::string_view name, mitsuba::PluginRegisterFn tell) {
    tell(name, Plugin::Variant, Plugin::Type, make_object<Plugin>);
}

/// Each file's own: compiled for other variants it is another function.
template <template <typename, typename> class Plugin>
static void register_variants(std::string_view name, mitsuba::PluginRegisterFn tell) {
    using mitsuba::Color;
    using mitsuba::MuellerMatrix;
    using Spectrum4 [[maybe_unused]] = mitsuba::Spectrum<float, 4>;
#if defined(EQUISTREAM_SCALAR_RGB)
    register_variant<Plugin<float, Color<float, 3>>>(name, tell);
#endif
#if defined(EQUISTREAM_SCALAR_SPECTRAL)
    register_variant<Plugin<float, Spectrum4>>(name, tell);
#endif
#if defined(EQUISTREAM_SCALAR_SPECTRAL_POLARIZED)
    register_variant<Plugin<float, MuellerMatrix<Spectrum4>>>(name, tell);
#endif
    using Llvm [[maybe_unused]] = drjit::DiffArray<JitBackend::LLVM, float>;
#if defined(EQUISTREAM_LLVM_AD_RGB)
    register_variant<Plugin<Llvm, Color<Llvm, 3>>>(name, tell);
#endif
#if defined(EQUISTREAM_LLVM_AD_MONO)
    register_variant<Plugin<Llvm, Color<Llvm, 1>>>(name, tell);
#endif
#if defined(EQUISTREAM_LLVM_AD_MONO_POLARIZED)
    register_variant<Plugin<Llvm, MuellerMatrix<Color<Llvm, 1>>>>(name, tell);
#endif
#if defined(EQUISTREAM_LLVM_AD_SPECTRAL)
    register_variant<Plugin<Llvm, mitsuba::Spectrum<Llvm, 4>>>(name, tell);
#endif
#if defined(EQUISTREAM_LLVM_AD_SPECTRAL_POLARIZED)
    register_variant<Plugin<Llvm, MuellerMatrix<mitsuba::Spectrum<Llvm, 4>>>>(name, tell);
#endif
    using Cuda [[maybe_unused]] = drjit::DiffArray<JitBackend::CUDA, float>;
#if defined(EQUISTREAM_CUDA_AD_RGB)
    register_variant<Plugin<Cuda, Color<Cuda, 3>>>(name, tell);
#endif
#if defined(EQUISTREAM_CUDA_AD_MONO)
    register_variant<Plugin<Cuda, Color<Cuda, 1>>>(name, tell);
#endif
#if defined(EQUISTREAM_CUDA_AD_MONO_POLARIZED)
    register_variant<Plugin<Cuda, MuellerMatrix<Color<Cuda, 1>>>>(name, tell);
#endif
#if defined(EQUISTREAM_CUDA_AD_SPECTRAL)
    register_variant<Plugin<Cuda, mitsuba::Spectrum<Cuda, 4>>>(name, tell);
#endif
#if defined(EQUISTREAM_CUDA_AD_SPECTRAL_POLARIZED)
    register_variant<Plugin<Cuda, MuellerMatrix<mitsuba::Spectrum<Cuda, 4>>>>(name, tell);
#endif
}

using RegisterVariants = void (*)(std::string_view name, mitsuba::PluginRegisterFn tell);

/// Calls this when Mitsuba loads the plugin. For objects of static storage duration.
struct Registration {
    explicit Registration(RegisterVariants register_them);
};

}  // namespace equistream::mitsuba_host

#define EQUISTREAM_EXPORT_PLUGIN(Name)                                                                                 \
    static const equistream::mitsuba_host::Registration registration(                                                  \
        &equistream::mitsuba_host::register_variants<Name>);
