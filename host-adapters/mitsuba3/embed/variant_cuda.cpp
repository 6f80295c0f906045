#include "variant_scene.h"

namespace equistream::mitsuba_host {

using Cuda = drjit::DiffArray<JitBackend::CUDA, float>;

#if defined(EQUISTREAM_CUDA_AD_RGB)
EQUISTREAM_VARIANT_SCENE(Cuda, mitsuba::Color<Cuda, 3>)
#endif
#if defined(EQUISTREAM_CUDA_AD_SPECTRAL)
EQUISTREAM_VARIANT_SCENE(Cuda, mitsuba::Spectrum<Cuda, 4>)
#endif
#if defined(EQUISTREAM_CUDA_AD_SPECTRAL_POLARIZED)
EQUISTREAM_VARIANT_SCENE(Cuda, mitsuba::MuellerMatrix<mitsuba::Spectrum<Cuda, 4>>)
#endif

}  // namespace equistream::mitsuba_host
