#pragma once
/// The parts of the module `equistream._core`, one file each.
#include <nanobind/nanobind.h>

namespace equistream::python {

void bind_cameras(nanobind::module_& m);
void bind_patches(nanobind::module_& m);
void bind_motion(nanobind::module_& m);
void bind_frame_info(nanobind::module_& m);
void bind_frames(nanobind::module_& m);
void bind_streams(nanobind::module_& m);
void bind_reprojection(nanobind::module_& m);
void bind_colour(nanobind::module_& m);

}  // namespace equistream::python
