#include "defines.h"

#include <equistream/conventions.h>
#include <equistream/depth_agreement.h>
#include <equistream/virtual_image.h>
#include <equistream/visible_loss.h>

namespace equistream::gl {

std::string common_constants() {
    Defines d;
    d.add("PI", pi);
    d.add_bits("UNKNOWN", 0x7fc00000u);
    d.add_bits("INFINITE", 0x7f800000u);
    d.add("FAR_DISTANCE_M", far_distance_m);
    d.add("MIN_SPECULAR", min_specular);
    d.add("LOSS_TEXTURES", VisibleLoss::textures);
    return d.take();
}

}  // namespace equistream::gl
