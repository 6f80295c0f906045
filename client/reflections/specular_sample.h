#pragma once
/// What one sample of a picture says of mirrors and glass (specular.h).
#include <client/warp/view.h>
#include <equistream/depth_agreement.h>
#include <equistream/virtual_image.h>

#include <algorithm>
#include <cmath>

namespace equistream {

/// Of a picture that has a mask.
struct SpecularSample {
    int x = 0, y = 0;
    bool specular = false;
};

inline SpecularSample specular_sample(const SourceView& source, int x, int y) {
    return {x, y, source.specular.pixel(x, y)[0] > min_specular};
}

/// Distance of the image that a sample shows, NaN where it is not known.
inline float image_distance(const SourceView& source, const SpecularSample& s) {
    if (source.virtual_depth_m.data == nullptr)
        return std::nanf("");
    const float distance_m = source.virtual_depth_m.pixel(s.x, s.y)[0];
    return distance_m > 0 ? std::min(distance_m, far_distance_m) : std::nanf("");
}

/// Whether an image at one distance, warped with a surface at another, stays within the budget; both as seen from the
/// picture's centre. An image whose distance nobody has told (NaN) lies somewhere from the surface to infinity.
inline bool warps_with_surface(const DepthAgreement& agreement, float surface_m, float image_m) {
    return std::abs((std::isnan(image_m) ? 0 : agreement.w(image_m)) - agreement.w(surface_m)) <= agreement.tolerance;
}

}  // namespace equistream
