#include <client/fill/fill.h>
#include <client/fill/push_pull.h>
#include <client/gpu/defines.h>
#include <client/warp/view.h>

#include <equistream/window.h>

namespace equistream::gl {

std::string fill_constants() {
    Defines d;
    d.add_whole("TILE_SHIFT", PullPyramid::tile_levels);
    d.add_unsigned("ORIGIN_BASE", unsigned(PixelOrigin::base));
    d.add("MIXED_PX", window_block_px);
    d.add_whole("MIX_STEPS", window_mix_steps);
    d.add("CHANGED_LIGHT", changed_light / 255.0);
    return d.take();
}

}  // namespace equistream::gl
