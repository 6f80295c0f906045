#pragma once
/// Engines that find on the GPU how far away is what the eyes see, and what they know of a source's lattice.
#include "eye_targets.h"
#include "source_textures.h"

#include <equistream/camera.h>

#include <client/gpu/objects.h>
#include <client/gpu/program.h>
#include <client/warp/engine.h>

#include <memory>
#include <optional>
#include <span>
#include <string_view>

namespace equistream::gl {

// What source_lattice.glsl knows of a source's lattice beside its depth: the sines and cosines of its columns and
// rows.

class LatticeTextures {
public:
    /// Kept as long as the camera stays. Whether it did.
    bool set(const Camera& camera);
    /// To the unit that source_lattice.glsl reads.
    void bind() const;

private:
    std::optional<Camera> camera_;
    Texture angles_;
};

// How near and how far blocks of a source's lattice show something, in which directions, and whether their samples are
// still the same (source_block.glsl).

class SourceBlocks {
public:
    SourceBlocks();

    /// Storage is kept as long as there are as many.
    void size_for(const Camera& camera);
    /// Of the depth of a source that EyeDepthFinder::bind has bound. What comes after may read them without a barrier
    /// of its own.
    void find() const;
    /// For a program that reads them at this binding.
    void bind(const Program& program, GLuint binding) const;

    int count() const { return grid_.width * grid_.height; }

private:
    Program pass_;
    Size grid_;
    Buffer blocks_;
};

// The first half of the engines that need the source alone, on the GPU: how far away is what the eyes see? The
// second half is Resample's.

/// What an engine needs, and what its depth is good for.
struct FinderTraits {
    bool needs_depth = true;  ///< of the source
    bool only_seen = true;    ///< points that the source did not see are gaps
    bool is_known = true;     ///< what it finds is what eyes see; else a place to look colours up by, no more
    double error_budget_px = default_error_budget_px;  ///< this engine's own; the look-up has it too
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
    void forget_gaps(const EyeTargets& targets) const;
    /// A layer for each eye; NaN where nothing was found.
    EyeDepth depth() const { return {depth_.name(), 1}; }

protected:
    /// Storage of depth() is kept as long as the size stays. Whether it did.
    bool size_for(Size size, int eyes);
    /// Image unit 0 is depth(), to be written.
    void bind_depth() const;
    /// Of the source, and of how the eyes look at it, for source_grid.glsl, eye_rays.glsl and source_lattice.glsl.
    void bind(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes);

    const FinderTraits traits_;
    EngineOptions options_;
    EyeBlocks eye_blocks_;
    LatticeTextures lattice_;
    Size size_;  ///< of the eyes
    int eyes_ = 0;

private:
    Program forget_gaps_{"forget_gaps.glsl"};
    Texture depth_;
};

/// What is taken unless told otherwise.
inline constexpr std::string_view default_finding_engine = "mesh";
/// `engine`: of engine_stages(). Null where it finds no depth itself. Throws InputError where OpenGL has no such
/// engine.
std::unique_ptr<EyeDepthFinder> make_eye_depth_from_source(std::string_view engine, const EngineOptions& options = {});

// Engine `proxy-sphere` (engine.h) on the GPU: rays as far as a sphere of one radius around the source.

class ProxySphereDepth : public EyeDepthFinder {
public:
    explicit ProxySphereDepth(const EngineOptions& options = {});

    void forget_source() override { radius_m_ = 0; }
    void find(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes) override;

private:
    Program pass_;
    float radius_m_ = 0;  ///< 0: not found yet
};

}  // namespace equistream::gl
