#include <client/extrapolate/extrapolate.h>
#include <client/gpu/defines.h>

namespace equistream::gl {

std::string extrapolate_constants() {
    Defines d;
    d.add("MAX_EXTRAPOLATED_M", max_extrapolated_m);
    d.add("MAX_HALF_HEIGHT", max_half_height);
    return d.take();
}

}  // namespace equistream::gl
