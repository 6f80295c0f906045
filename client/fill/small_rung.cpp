#include "rungs.h"

#include "../reproject/look_up.h"

#include <equistream/bound.h>

namespace equistream {

std::int64_t SmallRung::fill(const EyeView& eye, EyePicture& picture) const {
    if (!small_)
        return 0;
    LookUpOptions options;
    options.mark = PixelOrigin::small;
    options.only_gaps = true;
    options.tolerance_rad = error_budget_rad(eye.camera.focal_px());
    if (small_->depth_m.data == nullptr || eye.depth_m.data == nullptr)
        return look_up_by_direction(*small_, eye, options, picture);
    return look_up_by_surface(*small_, eye, options, picture);
}

}  // namespace equistream
