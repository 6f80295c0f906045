#include <client/extrapolate/moved_region.h>
#include <client/gpu/defines.h>

namespace equistream::gl {

std::string extrapolate_constants() {
    Defines d;
    d.add("FARTHEST_CARRIED_M", farthest_carried_m);
    d.add("LARGEST_HALF_HEIGHT", largest_half_height);
    return d.take();
}

}  // namespace equistream::gl
