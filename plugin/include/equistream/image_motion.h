#pragma once
/// Motion vectors and omnidirectional stereo. A motion vector leads from a pixel to the same point's position in a
/// neighbouring frame; it is the difference of the positions, in pixels. Results are finite for every direction that is
/// not 0. Templates on the scalar, as in conventions.h; C++17-clean.
#include <equistream/conventions.h>

namespace equistream {

/// On a sphere: the shortest way round the seam. `direction_there` is the point's direction in the neighbouring
/// camera's frame, of any length.
template <typename T>
PixelCoordinates<T> equirect_motion(PixelCoordinates<T> here, const Vector3<T>& direction_there, int width, int height,
                                    const LongitudeLatitudeRange& range) {
    const PixelCoordinates<T> there = equirect_pixel(direction_there, width, height, range);
    return {shortest_column_difference(T(there.u - here.u), width, range), there.v - here.v};
}

/// Distance from a perspective image's centre, in pixels, at which points behind the camera are put: eight diagonals.
inline double perspective_limit_px(int width, int height) {
    return 8 * std::hypot(width, height);
}

/// In a perspective view. A direction behind the neighbouring camera, or nearly at right angles to its axis, has no
/// position in the image. It is put perspective_limit_px away from the centre, in its own direction; a direction
/// straight behind is put to the right.
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

// Omnidirectional stereo (ODS). The rays of each column of an equirect image begin at a viewpoint of their own, on a
// horizontal circle with a radius of half the interpupillary distance. They leave the circle along its tangent there
// (Ishiguro, Yamamoto and Tsuji, "Omni-directional stereo", 1992; Google, "Rendering omni-directional stereo content",
// 2015).
//
// Towards the poles such viewpoints fit no head, and at a pole all columns meet. So the circle shrinks to a point
// there: between the latitudes `from` and `to` its radius is multiplied by
//     fade = (1 + cos(pi t)) / 2,     t = (|latitude| - from) / (to - from)
// The two angles and their defaults are those of Blender's "pole merge". Its fade cos(pi t / 2) has a kink at `to`, so
// it is squared here. Templates on the scalar, as in conventions.h; C++17-clean.

/// Latitudes, in radians, between which the eyes' separation fades to 0. It never fades if `from` is pi/2 or more.
struct PoleMerge {
    double from = pi / 3;
    double to = 5 * pi / 12;
};

/// The factor on the circle's radius: 1 up to `from`, 0 beyond `to`, smooth between them.
template <typename T>
T pole_fade(T latitude, const PoleMerge& merge) {
    using std::cos;
    if (!(merge.from < pi / 2))
        return T(1);
    const T height = select(latitude < T(0), T(-latitude), latitude);
    const T t = (height - T(merge.from)) * T(1 / (merge.to - merge.from));
    const T within = select(t < T(0), T(0), select(t > T(1), T(1), t));
    return T(0.5) + T(0.5) * cos(T(pi) * within);
}

/// Viewpoint of the ray with this longitude and latitude: metres, in the head's camera frame. `side_m` is half the
/// interpupillary distance, positive for the right eye, negative for the left.
template <typename T>
Vector3<T> ods_eye_offset(T longitude, T latitude, double side_m, const PoleMerge& merge) {
    using std::cos;
    using std::sin;
    const T radius = T(side_m) * pole_fade(latitude, merge);
    return {radius * cos(longitude), T(0), radius * sin(longitude)};
}

/// The unit direction of the ray that meets a point: the inverse of ods_eye_offset. The point is in the head's camera
/// frame, in metres from the circle's centre; a point inside the circle counts as on it.
template <typename T>
Vector3<T> ods_direction(const Vector3<T>& point, double side_m, const PoleMerge& merge) {
    using std::atan2;
    using std::sqrt;
    const T flat2 = point.x * point.x + point.z * point.z;
    T ahead = sqrt(flat2);
    T latitude = atan2(point.y, ahead);
    T radius = T(side_m) * pole_fade(latitude, merge);
    // The latitude depends on the radius and the radius on the latitude, but weakly: for points three radii away or
    // more the iteration ends within 2e-5 radians, for distances in a room within rounding.
    for (int step = 0; step < 6; ++step) {
        const T left = flat2 - radius * radius;
        ahead = sqrt(select(left > T(0), left, T(0)));
        latitude = atan2(point.y, ahead);
        radius = T(side_m) * pole_fade(latitude, merge);
    }
    return direction_from_longitude_latitude(T(longitude_of(point) - atan2(radius, ahead)), latitude);
}

}  // namespace equistream
