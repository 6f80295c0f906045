#pragma once
/// Colours of gap pixels by the points they see, from samples on a grid.
#include "patch_grid.h"
#include "seen_points.h"

namespace equistream {

struct GapResample {
    const EyeView& eye;
    const SeenPoints& seen;
    const Gaps& gaps;
    double error_budget_px;  ///< as in EngineOptions
    PixelOrigin mark = PixelOrigin::gap;
    /// Says where mirrors and glass are if the grid's picture does not itself; null: nobody does.
    const SourceView* main = nullptr;
    /// Take only samples whose colours are not mixed with what stands before them.
    bool unmixed_only = false;
};

/// Each gap pixel whose point is known and that the grid's pictures show too. Returns how many were coloured. What
/// mirrors and glass show is not on them: such a pixel is coloured only where the picture shows the same in them from
/// its own place, within the budget.
std::int64_t resample_gaps(const PictureGrid& grid, const GapResample& task, EyePicture& picture);
std::int64_t resample_gaps(const PatchGrid& grid, const GapResample& task, EyePicture& picture);

/// By direction alone, whatever the distance.
std::int64_t resample_gaps_by_direction(const PictureGrid& grid, const GapResample& task, EyePicture& picture);

}  // namespace equistream
