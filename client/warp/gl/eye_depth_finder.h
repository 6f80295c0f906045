#pragma once
/// The first half of the engines that need the source alone, on the GPU: how far away is what the eyes see? The
/// second half is Resample's.
#include "eye_blocks.h"
#include "eye_depth_layers.h"
#include "lattice_textures.h"
#include "source_textures.h"

#include <client/warp/engine.h>

#include <memory>
#include <span>
#include <string_view>

namespace equistream::gl {

/// What an engine needs, and what its depth is good for.
struct FinderTraits {
    bool needs_depth = true;  ///< of the source
    bool only_seen = true;    ///< points that the source did not see are gaps
    bool is_known = true;     ///< what it finds is what eyes see; else a place to look colours up by, no more
};

class EyeDepthFinder {
public:
    explicit EyeDepthFinder(const EngineOptions& options, const FinderTraits& traits = {})
        : traits_(traits), options_(options) {}
    virtual ~EyeDepthFinder() = default;
    EyeDepthFinder(const EyeDepthFinder&) = delete;
    EyeDepthFinder& operator=(const EyeDepthFinder&) = delete;

    /// The source's depth is another from now on.
    virtual void forget_source() = 0;
    const FinderTraits& traits() const { return traits_; }
    /// Finds the depth of eyes of one size, whose depth_m is not read; `source` has depth where that is needed. What
    /// comes after may sample depth() without a barrier of its own.
    virtual void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) = 0;

    /// Makes unknown what gap pixels of the targets see.
    void forget_gaps(const EyeTargets& targets) const { layers_.forget_gaps(targets); }
    /// A layer for each eye; NaN where nothing was found.
    EyeDepth depth() const { return layers_.depth(); }

protected:
    /// Of the source, and of how the eyes look at it, for source_grid.glsl, eye_rays.glsl and source_lattice.glsl.
    void bind(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes);

    const FinderTraits traits_;
    EngineOptions options_;
    EyeBlocks eye_blocks_;
    LatticeTextures lattice_;
    EyeDepthLayers layers_;
};

/// What is taken unless told otherwise.
inline constexpr std::string_view default_finding_engine = "mesh";
/// `engine`: of engine_stages(). Null where it finds no depth itself. Throws InputError where OpenGL has no such
/// engine.
std::unique_ptr<EyeDepthFinder> make_eye_depth_from_source(std::string_view engine, const EngineOptions& options = {});

}  // namespace equistream::gl
