#pragma once
/// The one definition of every mapping convention in equistream.
///
/// World: right-handed, +Y up, metres. Camera frame as in OpenGL: +X right, +Y up, -Z forward.
/// Equirect image: longitude l in [-pi, pi), 0 forward (-Z), positive to the right (+X); latitude p,
/// +pi/2 straight up and at the top row. Pixel coordinates are continuous: pixel (i, j) covers
/// [i, i+1) x [j, j+1), its centre is (i + 1/2, j + 1/2); column W of a full sphere is column 0.
///     u = (l - l_min) / (l_max - l_min) W          v = (p_max - p) / (p_max - p_min) H
///     direction = (cos p sin l, sin p, -cos p cos l)
///
/// Every function is a template on its scalar, so that one source serves C++ (float, double) and
/// vectorised types whose sin, cos, atan2, sqrt, floor and select are found by argument-dependent lookup.
/// This header stays C++17-clean and includes nothing but <cmath>.
#include <cmath>

namespace equistream {

inline constexpr double pi = 3.14159265358979323846;

template <typename T>
struct Vector3 {
    T x, y, z;
};

/// select() of scalars. Vectorised types supply overloads of their own.
inline float select(bool condition, float yes, float no) {
    return condition ? yes : no;
}
inline double select(bool condition, double yes, double no) {
    return condition ? yes : no;
}

/// Continuous pixel coordinates: u to the right, v downwards.
template <typename T>
struct PixelCoordinates {
    T u, v;
};

/// The longitudes and latitudes an equirect image covers, in radians. Defaults to the full sphere.
struct LongitudeLatitudeRange {
    double longitude_min = -pi;
    double longitude_max = pi;
    double latitude_min = -pi / 2;
    double latitude_max = pi / 2;

    constexpr double longitude_span() const { return longitude_max - longitude_min; }
    constexpr double latitude_span() const { return latitude_max - latitude_min; }
    /// Column W is column 0: the image closes on itself.
    constexpr bool closes() const { return longitude_span() > 2 * pi - 1e-9; }
    /// Every direction has a pixel.
    constexpr bool is_full_sphere() const { return closes() && latitude_span() > pi - 1e-9; }
};

/// Unit direction; angles in radians.
template <typename T>
Vector3<T> direction_from_longitude_latitude(T longitude, T latitude) {
    using std::cos;
    using std::sin;
    const T c = cos(latitude);
    return {c * sin(longitude), sin(latitude), -c * cos(longitude)};
}

/// Longitude in [-pi, pi]. `d` need not be normalised; at a pole the longitude is atan2(0, 0) = 0.
template <typename T>
T longitude_of(const Vector3<T>& d) {
    using std::atan2;
    return atan2(d.x, -d.z);
}

/// Latitude in [-pi/2, pi/2]; atan2 rather than asin keeps full precision next to the poles.
template <typename T>
T latitude_of(const Vector3<T>& d) {
    using std::atan2;
    using std::sqrt;
    return atan2(d.y, sqrt(d.x * d.x + d.z * d.z));
}

/// Unit direction of continuous pixel coordinates.
template <typename T>
Vector3<T> equirect_direction(PixelCoordinates<T> pixel, int width, int height, const LongitudeLatitudeRange& range) {
    const T longitude = T(range.longitude_min) + pixel.u * T(range.longitude_span() / width);
    const T latitude = T(range.latitude_max) - pixel.v * T(range.latitude_span() / height);
    return direction_from_longitude_latitude(longitude, latitude);
}

/// A unit direction and how it changes from one pixel to the next, to first order.
template <typename T>
struct DirectionDerivatives {
    Vector3<T> direction, per_column, per_row;
};

/// equirect_direction and its derivatives by u (per_column) and v (per_row), for texture filters.
template <typename T>
DirectionDerivatives<T> equirect_direction_derivatives(PixelCoordinates<T> pixel, int width, int height,
                                                       const LongitudeLatitudeRange& range) {
    using std::cos;
    using std::sin;
    const T longitude = T(range.longitude_min) + pixel.u * T(range.longitude_span() / width);
    const T latitude = T(range.latitude_max) - pixel.v * T(range.latitude_span() / height);
    const T sin_l = sin(longitude), cos_l = cos(longitude), sin_p = sin(latitude), cos_p = cos(latitude);
    const T across = cos_p * T(range.longitude_span() / width);
    const T down = T(range.latitude_span() / height);
    return {{cos_p * sin_l, sin_p, -cos_p * cos_l},
            {across * cos_l, T(0), across * sin_l},
            {down * sin_p * sin_l, -down * cos_p, -down * sin_p * cos_l}};
}

/// The inverse of equirect_direction. On an image that closes, u lies in [0, W]; on a partial range u is
/// the shortest way round from the range's middle, so a direction outside maps outside [0, W].
template <typename T>
PixelCoordinates<T> equirect_pixel(const Vector3<T>& direction, int width, int height,
                                   const LongitudeLatitudeRange& range) {
    using std::floor;
    const double middle = 0.5 * (range.longitude_min + range.longitude_max);
    const T turns = (longitude_of(direction) - T(middle)) * T(1 / (2 * pi));
    const T from_middle = (turns - floor(turns + T(0.5))) * T(2 * pi);
    return {from_middle * T(width / range.longitude_span()) + T(0.5 * width),
            (T(range.latitude_max) - latitude_of(direction)) * T(height / range.latitude_span())};
}

/// A difference of columns brought to the shortest way round: [-W/2, W/2) where the image closes.
template <typename T>
T shortest_column_difference(T difference, int width, const LongitudeLatitudeRange& range) {
    using std::floor;
    if (!range.closes())
        return difference;
    return difference - T(width) * floor(difference * T(1.0 / width) + T(0.5));
}

/// Solid angle in steradians of any pixel of row `row` of an equirect image.
inline double equirect_pixel_solid_angle(int row, int width, int height, const LongitudeLatitudeRange& range) {
    const double step = range.latitude_span() / height;
    const double top = range.latitude_max - row * step;
    return range.longitude_span() / width * (std::sin(top) - std::sin(top - step));
}

/// Focal length in pixels of a perspective view with the given horizontal field of view.
inline double focal_length_px(int width, double fov_x_rad) {
    return 0.5 * width / std::tan(0.5 * fov_x_rad);
}

/// Perspective: the (unnormalised) direction has z = -1, so its length times planar depth is radial depth.
template <typename T>
Vector3<T> perspective_direction(PixelCoordinates<T> pixel, int width, int height, double fov_x_rad) {
    const T inverse_focal = T(1 / focal_length_px(width, fov_x_rad));
    return {(pixel.u - T(0.5 * width)) * inverse_focal, (T(0.5 * height) - pixel.v) * inverse_focal, T(-1)};
}

/// The inverse of perspective_direction; meaningful only for directions in front (z < 0). `focal_px` is
/// focal_length_px.
template <typename T>
PixelCoordinates<T> perspective_pixel_of_focal(const Vector3<T>& direction, int width, int height, T focal_px) {
    const T scale = focal_px / -direction.z;
    return {T(0.5 * width) + direction.x * scale, T(0.5 * height) - direction.y * scale};
}

/// The same for a horizontal field of view.
template <typename T>
PixelCoordinates<T> perspective_pixel(const Vector3<T>& direction, int width, int height, double fov_x_rad) {
    return perspective_pixel_of_focal(direction, width, height, T(focal_length_px(width, fov_x_rad)));
}

}  // namespace equistream
