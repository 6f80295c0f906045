#pragma once
/// A source's depth by flat views from its centre (OpenGL).
#include "depth_pass.h"

#include <client/warp/gl/resample.h>
#include <client/warp/gl/source_textures.h>
#include <client/warp/view.h>

#include <array>
#include <cassert>
#include <cstddef>
#include <span>

namespace equistream::gl {

// Flat views from a source's centre that together show every sample which some eyes may look up.

/// Rectangle of a source's samples; columns may run over the seam.
struct SampleRange {
    int first_column = 0, first_row = 0, columns = 0, rows = 0;
};

/// As many as a cube has faces at most, and no memory of its own: it is made anew at every refresh.
class SourceViewpoints {
public:
    static constexpr std::size_t most = 6;

    void push_back(const DepthViewpoint& view) {
        assert(count_ < views_.size());
        views_[count_++] = view;
    }
    std::size_t size() const { return count_; }
    const DepthViewpoint* data() const { return views_.data(); }
    const DepthViewpoint* begin() const { return data(); }
    const DepthViewpoint* end() const { return data() + count_; }
    const DepthViewpoint& front() const { return views_[0]; }
    const DepthViewpoint& operator[](std::size_t i) const { return views_[i]; }

private:
    std::array<DepthViewpoint, most> views_{};
    std::size_t count_ = 0;
};

struct SphereViews {
    SourceViewpoints views;  ///< world poses
    SampleRange samples;     ///< all that lie in one of them, and more
};

/// Surfaces that are nearer to the source's centre than this may be looked up beyond what is shown; eyes that are
/// farther from it than this get every sample.
inline constexpr double nearest_shown_m = 0.5;

/// One view where the eyes do not see too wide for it, else faces of a cube that looks where they look, as many as are
/// needed. With every sample that is looked up come the sixteen around it. Texels are as dense as samples in the middle
/// of a view, denser elsewhere.
SphereViews sphere_views(const EquirectCamera& camera, const Pose& pose, std::span<const EyeView> eyes);

/// The six faces of a cube with the source's axes, and all samples: as the paper renders its equirectangular depth.
SphereViews cube_views(const EquirectCamera& camera, const Pose& pose);

/// A flat source's own view, for all of its samples.
SphereViews flat_source_views(const PerspectiveCamera& camera, const Pose& pose);

// Turns flat views of depth into the depth of a source's samples (OpenGL).

class SphereDepth {
public:
    /// Interpolated depth stays within `error_rad` by the bound (bound.h), for eyes in a ball of this radius.
    SphereDepth(double box_radius_m, double error_rad);

    /// Writes the depth of those of `views.samples` that one of `views.views` shows into the source's depth texture,
    /// from the pass's layers that start with `first_layer`. Other samples keep what they had.
    void resolve(const DepthPass& pass, int first_layer, const SphereViews& views, const Pose& source_pose,
                 SourceTextures& source);

private:
    /// For so many views.
    struct Passes {
        explicit Passes(std::size_t views);
        Program first;   ///< every sample, where the rule is simple
        Program listed;  ///< the others
    };

    float box_radius_m_, error_;
    Passes one_view_, faces_;
    PixelList list_;
    Buffer views_;
};

}  // namespace equistream::gl
