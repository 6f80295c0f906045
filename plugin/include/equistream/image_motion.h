#pragma once
/// The one definition of motion in an image: from a pixel to where the same thing is in a neighbouring frame, as the
/// difference of positions in pixels. Results are finite for every direction that is not 0. Templates on the scalar as
/// conventions.h has them; C++17-clean.
#include <equistream/conventions.h>

namespace equistream {

/// On a sphere: the shortest way round the seam. `direction_there` is in the other camera's frame, of any length.
template <typename T>
PixelCoordinates<T> equirect_motion(PixelCoordinates<T> here, const Vector3<T>& direction_there, int width, int height,
                                    const LongitudeLatitudeRange& range) {
    const PixelCoordinates<T> there = equirect_pixel(direction_there, width, height, range);
    return {shortest_column_difference(T(there.u - here.u), width, range), there.v - here.v};
}

/// Distance from a perspective image's centre that stands for "behind the camera": eight image diagonals.
inline double perspective_limit_px(int width, int height) {
    return 8 * std::hypot(width, height);
}

/// In a perspective view: a direction behind the other camera (or nearly beside it) counts as out of the image in its
/// own direction from the centre, perspective_limit_px away; one straight behind, to the right.
template <typename T>
PixelCoordinates<T> perspective_motion(PixelCoordinates<T> here, const Vector3<T>& direction_there, int width,
                                       int height, T focal_px) {
    using std::sqrt;
    const T limit = T(perspective_limit_px(width, height));
    const Vector3<T>& d = direction_there;
    const T aside = sqrt(d.x * d.x + d.y * d.y);
    const auto inside = -d.z * limit > aside * focal_px;
    const auto sideways = aside > T(0);
    const T inverse = T(1) / select(sideways, aside, T(1));
    const T right = select(sideways, T(d.x * inverse), T(1));
    const T up = select(sideways, T(d.y * inverse), T(0));
    const PixelCoordinates<T> seen =
        perspective_pixel_of_focal(Vector3<T>{d.x, d.y, select(inside, d.z, T(-1))}, width, height, focal_px);
    return {select(inside, seen.u, T(T(0.5 * width) + limit * right)) - here.u,
            select(inside, seen.v, T(T(0.5 * height) - limit * up)) - here.v};
}

}  // namespace equistream
