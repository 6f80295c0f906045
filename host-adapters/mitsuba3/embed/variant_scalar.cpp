#include "variant_scene.h"

namespace equistream::mitsuba_host {

EQUISTREAM_VARIANT_SCENE(float, mitsuba::Color<float, 3>)
#if defined(EQUISTREAM_SCALAR_SPECTRAL)
EQUISTREAM_VARIANT_SCENE(float, mitsuba::Spectrum<float, 4>)
#endif
#if defined(EQUISTREAM_SCALAR_SPECTRAL_POLARIZED)
EQUISTREAM_VARIANT_SCENE(float, mitsuba::MuellerMatrix<mitsuba::Spectrum<float, 4>>)
#endif

}  // namespace equistream::mitsuba_host
