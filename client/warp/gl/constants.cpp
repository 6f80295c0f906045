#include "eye_targets.h"

#include <client/gpu/defines.h>
#include <client/warp/resample.h>
#include <client/warp/source_lattice.h>
#include <client/warp/view.h>

#include <bit>

namespace equistream::gl {

std::string warp_constants() {
    Defines d;
    d.add("MIN_WEIGHT", min_weight);
    d.add_whole("MAX_EYES", max_eyes);
    d.add_whole("POSITION_BITS", position_bits);
    d.add_whole("POSITION_ONE", position_one);
    d.add_whole("BLOCK_LEVELS", std::countr_zero(unsigned(LatticeBlock::side)));
    d.add_unsigned("ORIGIN_GAP", unsigned(PixelOrigin::gap));
    d.add_unsigned("ORIGIN_SOURCE", unsigned(PixelOrigin::source));
    d.add_unsigned("ORIGIN_PUSH_PULL", unsigned(PixelOrigin::push_pull));
    return d.take();
}

}  // namespace equistream::gl
