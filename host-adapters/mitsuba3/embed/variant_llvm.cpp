#include "variant_scene.h"

namespace equistream::mitsuba_host {

using Llvm = drjit::DiffArray<JitBackend::LLVM, float>;

#if defined(EQUISTREAM_LLVM_AD_RGB)
EQUISTREAM_VARIANT_SCENE(Llvm, mitsuba::Color<Llvm, 3>)
#endif
#if defined(EQUISTREAM_LLVM_AD_SPECTRAL)
EQUISTREAM_VARIANT_SCENE(Llvm, mitsuba::Spectrum<Llvm, 4>)
#endif
#if defined(EQUISTREAM_LLVM_AD_SPECTRAL_POLARIZED)
EQUISTREAM_VARIANT_SCENE(Llvm, mitsuba::MuellerMatrix<mitsuba::Spectrum<Llvm, 4>>)
#endif

}  // namespace equistream::mitsuba_host
