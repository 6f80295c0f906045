#pragma once
/// The patches of one of an atlas' spheres, as samples on that sphere's grid.
#include "sample_grid.h"

#include <equistream/patches.h>
#include <equistream_client/fill.h>

namespace equistream {

class PatchGrid {
public:
    /// `index` is of the view's atlas, whose offset with this number the sphere is at. All is borrowed.
    PatchGrid(const PatchesView& view, const PatchIndex& index, int offset)
        : view_(view), index_(index), offset_(offset), side_(view.atlas->block_side),
          camera_(view.atlas->sphere()), pose_{view.pose.position_m +
                                                   view.pose.orientation * view.atlas->offsets_m[std::size_t(offset)],
                                               view.pose.orientation} {}

    const Camera& camera() const { return camera_; }
    const Pose& pose() const { return pose_; }
    double box_radius_m() const { return view_.box_radius_m; }
    bool find(int x, int y, SamplePlace& place) const {
        const auto at = index_.atlas_pixel(offset_, x, y);
        if (at)
            place = {at->x, at->y};
        return at.has_value();
    }
    float depth_m(SamplePlace p) const { return view_.depth_m.pixel(p.x, p.y)[0]; }
    Vec3f colour(SamplePlace p) const { return sample_colour(view_.rgb, view_.yuv, p.x, p.y); }
    /// Whether a square of samples, which lies in the sphere, may hold any.
    bool holds_block(int left, int top, int side) const {
        const int right = std::min(left + side, view_.atlas->sphere_width) - 1;
        const int bottom = std::min(top + side, view_.atlas->sphere_height) - 1;
        for (int y = top / side_; y <= bottom / side_; ++y)
            for (int x = left / side_; x <= right / side_; ++x)
                if (index_.slot_of(offset_, x, y) >= 0)
                    return true;
        return false;
    }

private:
    const PatchesView& view_;
    const PatchIndex& index_;
    int offset_, side_;
    Camera camera_;
    Pose pose_;
};

}  // namespace equistream
