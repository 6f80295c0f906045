#pragma once
/// What gap pixels see where the eye has no depth of its own: the surfaces of a grid's samples, drawn forward into the
/// gaps, nearest first. Neighbouring samples of one surface are joined by triangles (1 / planar depth is linear on
/// them); where a surface ends, its last samples reach as far as the next, the background before the foreground.
#include "gap_resample.h"
#include "gaps.h"

#include <functional>

namespace equistream {

/// Whether the surface is still where a sample shows it; world coordinates.
using StillThere = std::function<bool(const glm::dvec3& point_world)>;

struct ForwardTask {
    const EyeView& eye;
    const Gaps& gaps;
    const EyePicture& picture;
    SeenPoints& seen;
    double error_budget_px;  ///< as in EngineOptions; what is closer belongs to one surface
};
/// Brings 1 / planar depth of the gap pixels up to that of the nearest surface that falls on them; NaN counts as
/// farthest. Only samples that are `still_there`, where that is given. The grid must have depth.
void draw_forward(const PictureGrid& grid, const ForwardTask& task, const StillThere& still_there = {});
void draw_forward(const PatchGrid& grid, const ForwardTask& task);
/// To be called when all grids are drawn, before `seen` is read.
void end_drawing(const ForwardTask& task);

}  // namespace equistream
