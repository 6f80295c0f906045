#include "rungs.h"

#include "../reproject/look_up.h"

#include <equistream/bound.h>

namespace equistream {

std::int64_t SmallRung::fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const {
    if (small_ == nullptr)
        return 0;
    LookUpOptions options;
    options.mark = PixelOrigin::small;
    options.only_gaps = true;
    options.tolerance_rad = error_budget_rad(eye.camera.focal_px());
    const bool with_depth = small_->depth_m.data != nullptr && eye.depth_m.data != nullptr;
    const std::int64_t filled = with_depth ? look_up_by_surface(*small_, eye, options, picture)
                                           : look_up_by_direction(*small_, eye, options, picture);
    gaps.narrow(picture.origin.view());
    return filled;
}

}  // namespace equistream
