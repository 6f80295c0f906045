#pragma once
/// Engines that find the eye's depth from the source's.
#include "engine.h"
#include "source_lattice.h"

#include <memory>

namespace equistream {

// Engines that find the eye's depth and look colours up as `eye-depth` does.

/// `name`: splat, mesh, mesh-plain or proxy-sphere.
std::unique_ptr<Engine> make_source_depth_engine(std::string_view name, const EngineOptions& options);

// The first half of the engines that need the source's depth only: how far from the eye is what each of its pixels
// sees? The second half is theirs and the `eye-depth` engine's alike: the point found is looked up in the source, once,
// bilinearly, and samples of other surfaces are left out. So an error of the distance found moves colour along one
// line only and by what the bound says, and no footprint or triangle blurs or smears colour.

/// Of one eye and one source, for the length of a call.
struct FindingTask {
    const SourceView& source;
    const SourceLattice& lattice;
    const EyeView& eye;
    DepthAgreement same_surface;  ///< the whole budget: what is one surface
    float share = 0;              ///< sine of the part of the budget that this approximation may use up
};

/// 1 / planar depth of a pixel where nothing was found; any found is >= 0.
inline constexpr float nothing_found = -1;

/// Of `splat`: half a side of the largest footprint in pixels. Larger ones belong to what is so near to the eye, and so
/// far from the source by comparison, that its samples are no picture any more.
inline constexpr float max_half_side = 32;
/// Of `splat`: a pixel of the source more on either side, against cracks from rounding and from the parallelogram being
/// one.
inline constexpr float footprint_overlap = 0.05f;

// Both fill `inverse_planar` (the eye's size), which holds nothing_found everywhere. Any number of threads.

void find_by_splats(const FindingTask& task, FloatImage& inverse_planar);
/// `plain`: every cell of the lattice, joined to its neighbours whatever lies between.
void find_by_mesh(const FindingTask& task, bool plain, FloatImage& inverse_planar);

// Leaning inside the sphere without depth, as in the paper: the pictures lie on a sphere of one radius around the
// source, and the eye moves inside it. Right where things are at that distance.

/// EngineOptions::proxy_radius_m where that is given; else the median of the source's depths, each direction counting
/// alike, if it has some and not most of them are infinite; else 3 m, as far as walls and furniture are.
double proxy_radius_m(const SourceView& source, const EngineOptions& options);

/// The distance at which rays leave the sphere; an eye outside sees its far side, as far as that goes.
void find_on_proxy_sphere(const SourceView& source, const EyeView& eye, double radius_m, FloatImage& inverse_planar);

}  // namespace equistream
