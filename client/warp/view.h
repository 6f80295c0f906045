#pragma once
/// What goes into a reprojection and what comes out of it. Views borrow their pixels; whoever makes one keeps the
/// pixels alive and unchanged while it is in use. Everything may be read by any number of threads.
#include <equistream/camera.h>
#include <equistream/image.h>
#include <equistream/yuv.h>

#include <cstdint>

namespace equistream {

/// A picture that was rendered elsewhere: the sphere, or the paper's single perspective view. All planes have the
/// camera's size.
struct SourceView {
    /// Display-referred sRGB, 3 or 4 channels (the fourth is not read); or empty where `yuv` is given.
    ImageView<const std::uint8_t> rgb{};
    YuvView yuv{};  ///< a decoder's own planes, sides even; used where `rgb` is empty
    Camera camera{};
    Pose pose{};                        ///< world from camera
    ImageView<const float> depth_m{};   ///< radial distance along each pixel-centre ray, +inf for a miss; or empty
    ImageView<const float> specular{};  ///< how far the first surface is mirror or glass, 0 to 1; or empty
    ImageView<const float> virtual_depth_m{};  ///< where on that ray its mirrored or refracted image lies; or empty
    double box_radius_m = 0;                   ///< head box around the source's centre (bound.h), for depth tolerances
};

/// What an eye wants to see.
struct EyeView {
    PerspectiveCamera camera;
    Pose pose;
    ImageView<const float> depth_m{};  ///< as in SourceView, from the eye, of local geometry; or empty
};

/// Who gave a pixel of an EyePicture its colour.
enum class PixelOrigin : std::uint8_t {
    gap = 0,         ///< nobody yet
    source = 1,      ///< the main source
    small = 2,       ///< the small second-eye view
    neighbours = 3,  ///< spread from the pixels around it
    earlier = 4,     ///< an earlier frame
    patches = 5,     ///< patches that the server predicted
    hidden = 6,      ///< the source's second layer
    geometry = 7,    ///< a raster or ray cast of the client's geometry
    push_pull = 8,   ///< coarser levels of the picture itself
    base = 9,        ///< the coarse sphere around a window
};
inline constexpr int pixel_origin_count = 10;

/// One eye's finished view.
struct EyePicture {
    ByteImage rgba;         ///< 4 channels, display-referred sRGB; alpha 255 where coloured, all four 0 where a gap
    ByteImage origin;       ///< PixelOrigin, 1 channel
    ByteImage reliability;  ///< 1 channel, 255 times a probability; empty unless somebody estimated it
    /// Radial distance from the eye to what each pixel shows, +inf for a miss, NaN for a gap, 1 channel; only of
    /// engines that find it themselves, else empty.
    FloatImage depth_m;

    /// Sizes `rgba` and `origin`, for whoever writes every pixel; the others are emptied.
    void size_for(const PerspectiveCamera& camera);
    /// The same, and makes every pixel a gap.
    void reset(const PerspectiveCamera& camera);
    std::int64_t count(PixelOrigin which) const;
    /// The colours alone, 3 channels.
    ByteImage rgb() const;
};

}  // namespace equistream
