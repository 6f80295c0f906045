#pragma once
/// Leaning inside the sphere without depth, as in the paper: the pictures lie on a sphere of one radius around the
/// source, and the eye moves inside it. Right where things are at that distance.
#include "eye_depth_from_source.h"

namespace equistream {

/// EngineOptions::proxy_radius_m where that is given; else the median of the source's depths, each direction counting
/// alike, if it has some and not most of them are infinite; else 3 m, as far as walls and furniture are.
double proxy_radius_m(const SourceView& source, const EngineOptions& options);

/// The distance at which rays leave the sphere; an eye outside sees its far side, as far as that goes.
void find_on_proxy_sphere(const SourceView& source, const EyeView& eye, double radius_m, FloatImage& inverse_planar);

}  // namespace equistream
