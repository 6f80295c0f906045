#pragma once
/// Between the contract's camera frame (+X right, -Z forward) and Mitsuba's (+X left, +Z forward): half a turn about
/// +Y, which is its own inverse.
#include <equistream/conventions.h>

namespace equistream::mitsuba_host {

template <typename Vector, typename T>
Vector mitsuba_frame(const Vector3<T>& v) {
    return Vector(-v.x, v.y, -v.z);
}

template <typename T, typename Vector>
Vector3<T> contract_frame(const Vector& v) {
    return {-v.x(), v.y(), -v.z()};
}

}  // namespace equistream::mitsuba_host
