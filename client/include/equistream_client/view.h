#pragma once
/// What goes into a reprojection and what comes out of it. Views borrow their pixels; whoever makes one keeps the
/// pixels alive and unchanged while it is in use. Everything may be read by any number of threads.
#include <equistream/camera.h>
#include <equistream/image.h>

#include <cstdint>

namespace equistream {

/// A picture that was rendered elsewhere: the sphere, or the paper's single perspective view.
struct SourceView {
    ImageView<const std::uint8_t> rgb;  ///< display-referred sRGB, 3 channels, the camera's size
    Camera camera;
    Pose pose;                         ///< world from camera
    ImageView<const float> depth_m{};  ///< radial distance along each pixel-centre ray, +inf for a miss; or empty
    double box_radius_m = 0;           ///< head box around the source's centre (bound.h), for depth tolerances
};

/// What an eye wants to see.
struct EyeView {
    PerspectiveCamera camera;
    Pose pose;
    ImageView<const float> depth_m{};  ///< as in SourceView, from the eye; empty for methods that need none
};

/// Who gave a pixel of an EyePicture its colour.
enum class PixelOrigin : std::uint8_t {
    gap = 0,         ///< nobody yet
    source = 1,      ///< the main source
    small = 2,       ///< the small second-eye view
    neighbours = 3,  ///< spread from the pixels around it
};
inline constexpr int pixel_origin_count = 4;

/// One eye's finished view. `rgb` is 0 where `origin` is gap.
struct EyePicture {
    FloatImage rgb;    ///< display-referred sRGB in [0, 1], 3 channels
    ByteImage origin;  ///< PixelOrigin, 1 channel

    std::int64_t count(PixelOrigin which) const;
};

}  // namespace equistream
