#pragma once
/// Colours of gap pixels by the points they see, from samples on a grid: a picture's or an atlas'.
#include "fill.h"
#include "gaps.h"

#include <equistream/patches.h>

#include <client/warp/resample.h>

#include <functional>

namespace equistream {

// The patches of one of an atlas' spheres, as samples on that sphere's grid.

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
    glm::vec3 colour(SamplePlace p) const { return sample_colour(view_.rgb, view_.yuv, p.x, p.y); }
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

// Colours of gap pixels by the points they see, from samples on a grid.

struct GapResampleTask {
    const EyeView& eye;
    const SeenPoints& seen;
    const Gaps& gaps;
    double error_budget_px;  ///< as in EngineOptions
    PixelOrigin mark = PixelOrigin::gap;
    /// Says where mirrors and glass are if the grid's picture does not itself; null: nobody does.
    const SourceView* main = nullptr;
    /// Take only samples whose colours are not mixed with what stands before them.
    bool unmixed_only = false;
    /// Whether what the grid's picture shows of a pixel's point is not so any more; empty: it is.
    std::function<bool(int x, int y)> is_outdated{};
};

/// Each gap pixel whose point is known and that the grid's pictures show too. Returns how many were coloured. What
/// mirrors and glass show is not on them: such a pixel is coloured only where the picture shows the same in them from
/// its own place, within the budget.
std::int64_t resample_gaps(const PictureGrid& grid, const GapResampleTask& task, EyePicture& picture);
std::int64_t resample_gaps(const PatchGrid& grid, const GapResampleTask& task, EyePicture& picture);

/// By direction alone, whatever the distance.
std::int64_t resample_gaps_by_direction(const PictureGrid& grid, const GapResampleTask& task, EyePicture& picture);

}  // namespace equistream
