#pragma once
/// A headset's eyes look through frusta that are not symmetric; ours are. What is drawn is the symmetric view, of
/// square pixels and one size for both eyes, that covers both; what is shown of it is a rectangle of whole pixels,
/// whose own angles are said along with it. So nothing is resampled once more.
#include <equistream/camera.h>

#include <array>

namespace equistream {

/// From the middle of the view, radians; left and down are negative.
struct FieldOfView {
    double left_rad = 0, right_rad = 0, up_rad = 0, down_rad = 0;
};

/// Pixels, the first row at the top.
struct ViewPart {
    int left = 0, top = 0, width = 0, height = 0;
    FieldOfView fov;  ///< that it has exactly
};

struct ViewSize {
    int width = 0, height = 0;
};

/// More than any display has.
inline constexpr ViewSize max_covering_view{16384, 16384};

struct CoveringView {
    PerspectiveCamera camera;
    std::array<ViewPart, 2> parts;  ///< by eye
};

/// `columns` are what the left eye's field of view shall have at least; both cameras stay within `most`. Angles lie
/// between -85 and 85 degrees where they are used.
CoveringView covering_view(const std::array<FieldOfView, 2>& eyes, int columns, ViewSize most);

/// The same with as many pixels as leave neither part larger than `room`. The middle lies within a pixel where a side
/// of `room` is odd.
CoveringView fitted_view(const std::array<FieldOfView, 2>& eyes, ViewSize room, ViewSize most);

}  // namespace equistream
