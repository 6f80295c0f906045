#pragma once
/// The patches of one of an atlas' spheres, as samples on that sphere's grid.
#include <client/warp/sample_grid.h>
#include <equistream/patch_slots.h>

#include "fill.h"

namespace equistream {

class PatchGrid {
public:
    /// `slots` are of the view's atlas, whose offset with this number the sphere is at. All is borrowed.
    PatchGrid(const PatchesView& view, const PatchSlots& slots, int offset)
        : view_(view), slots_(slots), offset_(offset), side_(view.atlas->block_side),
          camera_(view.atlas->sphere()), pose_{view.pose.position_m +
                                                   view.pose.orientation * view.atlas->offsets_m[std::size_t(offset)],
                                               view.pose.orientation} {}

    const Camera& camera() const { return camera_; }
    const Pose& pose() const { return pose_; }
    double box_radius_m() const { return view_.box_radius_m; }
    bool find(int x, int y, SamplePlace& place) const {
        const auto at = slots_.atlas_pixel(offset_, x, y);
        if (at)
            place = {at->x, at->y};
        return at.has_value();
    }
    float depth_m(SamplePlace p) const { return view_.depth_m.pixel(p.x, p.y)[0]; }
    Vec3f colour(SamplePlace p) const { return sample_colour(view_.rgb, view_.yuv, p.x, p.y); }
    /// Whether a rectangle of samples, whose corner lies in the sphere, may hold any.
    bool holds_any(int left, int top, int width, int height) const {
        const int right = std::min(left + width, view_.atlas->sphere_width) - 1;
        const int bottom = std::min(top + height, view_.atlas->sphere_height) - 1;
        for (int y = top / side_; y <= bottom / side_; ++y)
            if (slots_.shows_any(offset_, left / side_, right / side_, y))
                return true;
        return false;
    }

private:
    const PatchesView& view_;
    const PatchSlots& slots_;
    int offset_, side_;
    Camera camera_;
    Pose pose_;
};

}  // namespace equistream
