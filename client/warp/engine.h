#pragma once
/// Reprojection engines: a source picture turned into what an eye sees. Each resamples colour once.
///
/// `rotation` rotation only: the eye's pixel takes the colour of its direction; the eye's position is ignored.
/// `eye-depth` the eye's own depth gives the point that the pixel sees; its direction from the source's centre gives
///            the colour. Of the four samples around it those whose own depth shows another surface are left out
///            (equistream/depth_agreement.h has the tolerance); where none is left the source did not see the point: a
///            gap. From the source's own position this is `rotation`; for the source's very view it returns its input.
///
/// `proxy-sphere` no depth: the pictures lie on a sphere of one radius, and the eye moves inside it, as in the paper.
///
/// The others need the source's depth only and find the eye's themselves, so they fill EyePicture::depth_m (unless the
/// eye is at the source's position, where nothing needs it); the colour of what they find is looked up as `eye-depth`
/// does.
///
/// `splat`    forward: each sample of the source is drawn as the parallelogram of the eye's pixels that it covers, in
///            the order of McMillan 1995 that needs no buffer of depths.
/// `mesh`     the source's depth as cells as large as keep w within `mesh_share` of the budget, cut where w jumps more
///            than a surface's slope explains; drawn with a buffer of depths.
/// `mesh-plain`  every cell of the source's depth, never cut, each point coloured whether the source saw it or not: the
///            baseline that stretches rubber sheets from edges to what lies behind.
///
/// Any source camera works. Directions that a source does not cover are gaps.
#include "view.h"

#include <equistream/bound.h>

#include <memory>
#include <span>
#include <string_view>

namespace equistream {

/// Budget of `mesh` and `splat` (docs/decisions/0016). Larger cells and fewer cuts bridge small steps of depth, and
/// that is nearer the truth than filling what was cut.
inline constexpr double default_source_depth_budget_px = 2;

struct EngineOptions {
    /// Share of a pixel of the eye's view (at its centre) by which a colour sample may be displaced.
    double error_budget_px = default_error_budget_px;
    /// The same for `mesh` and `splat`.
    double source_depth_budget_px = default_source_depth_budget_px;
    /// Of that budget, what `mesh` may use up for its own approximation; the rest is for depth codes and
    /// codec and geometry.
    double mesh_share = default_budget_share;
    /// For `proxy-sphere`: the radius of its sphere of pictures; 0: the median of the source's depths where it has
    /// some, else 3 m.
    double proxy_radius_m = 0;

    /// The budget of one engine.
    double budget_px_of(std::string_view engine) const {
        return engine == "mesh" || engine == "splat" ? source_depth_budget_px : error_budget_px;
    }
};

/// Whose depth a reprojection cannot do without.
struct DepthNeeds {
    bool source = false, eye = false;

    bool any() const { return source || eye; }
};

/// set_source, then reproject for any number of eyes, from any number of threads.
class Engine {
public:
    virtual ~Engine() = default;
    virtual std::string_view name() const = 0;
    /// For an eye at the source's position, nobody's.
    virtual DepthNeeds needs_depth(const Pose& source, const Pose& eye) const = 0;
    /// Borrows the view's pixels until the next call.
    virtual void set_source(const SourceView& source) = 0;
    /// Sizes and overwrites `picture`. Missing depth, where it is needed, is a programmer error.
    virtual void reproject(const EyeView& eye, EyePicture& picture) const = 0;
};

/// `name`: of a row of engine_stages() (stages.h). Throws InputError naming the accepted ones.
std::unique_ptr<Engine> make_engine(std::string_view name, const EngineOptions& options = {});

/// Same place to within a nanometre.
bool same_position(const Pose& a, const Pose& b);
/// Same place, and axes to within 1e-7 rad: a ten-thousandth of a pixel at a focal length of 960.
bool same_pose(const Pose& a, const Pose& b);
/// Same projection, size and field of view.
bool same_camera(const Camera& a, const Camera& b);

// Engines that look each pixel of the eye up in the source: by its direction, or by the eye's own depth.

/// `name`: rotation or eye-depth.
std::unique_ptr<Engine> make_resample_engine(std::string_view name, const EngineOptions& options);

}  // namespace equistream
