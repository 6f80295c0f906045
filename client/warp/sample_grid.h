#pragma once
/// Where fill passes take colours from, as samples on the pixel grid of a camera: here every pixel of a picture, in
/// patch_grid.h the blocks of a sphere that an atlas of patches holds.
#include "float_math.h"

#include "view.h"

#include <algorithm>

namespace equistream {

/// Colour of one sample, 0 to 255.
inline Vec3f sample_colour(ImageView<const std::uint8_t> rgb, const YuvView& yuv, int x, int y) {
    if (rgb.data != nullptr) {
        const std::uint8_t* sample = rgb.pixel(x, y);
        return {float(sample[0]), float(sample[1]), float(sample[2])};
    }
    const yuv_to_rgb::Rgb sample = yuv_to_rgb::rgb_at(yuv, x, y);
    return {float(sample[0]), float(sample[1]), float(sample[2])};
}

/// Pixels of its picture that a grid's samples lie in.
struct SamplePlace {
    int x = 0, y = 0;
};

class PictureGrid {
public:
    explicit PictureGrid(const SourceView& view) : view_(view) {}

    const SourceView& view() const { return view_; }
    const Camera& camera() const { return view_.camera; }
    const Pose& pose() const { return view_.pose; }
    double box_radius_m() const { return view_.box_radius_m; }
    /// Of the sample at column x and row y of the camera; false where the picture does not hold it.
    bool find(int x, int y, SamplePlace& place) const {
        place = {x, y};
        return true;
    }
    float depth_m(SamplePlace p) const { return view_.depth_m.pixel(p.x, p.y)[0]; }
    Vec3f colour(SamplePlace p) const { return sample_colour(view_.rgb, view_.yuv, p.x, p.y); }
    /// Whether a rectangle of samples may hold any.
    bool holds_any(int, int, int, int) const { return true; }

private:
    const SourceView& view_;
};

}  // namespace equistream
