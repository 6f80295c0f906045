#include <client/fill/push_pull.h>
#include <client/gpu/defines.h>

namespace equistream::gl {

std::string fill_constants() {
    Defines d;
    d.add_whole("TILE_SHIFT", PullPyramid::tile_levels);
    return d.take();
}

}  // namespace equistream::gl
