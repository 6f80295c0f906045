#pragma once
/// Resampling on the GPU, and the pixels that its first pass leaves to its second.
#include "eye_targets.h"
#include "source_textures.h"

#include <client/gpu/program.h>

#include <cstddef>
#include <span>

namespace equistream::gl {

// Pixels that a first pass leaves to a second one, listed on the GPU: where lanes run both sides of every branch, a
// rule that few pixels need would cost all of them.

class PixelList {
public:
    PixelList();

    /// For so many pixels, of up to 32,768 columns and rows and four layers. Storage grows and is kept.
    void size_for(std::size_t pixels);
    /// Empties the list, and binds it for shaders that include pixel_list.glsl.
    void start() const;
    /// Runs such a program, whose groups are of 256, once for each pixel that was listed before.
    void dispatch(const Program& program) const;

private:
    Program groups_;
    std::size_t pixels_ = 0;
    Buffer head_, list_;
};

// Engines `rotation` and `eye-depth` (engine.h) on the GPU, for all eyes at once; and the second half of those that
// find the eyes' depth.

/// direction: the eyes' places are ignored. seen: by the eyes' own depth, where the source saw that point too. any: by
/// that depth, whatever the source saw there; its own is not read.
enum class ResampleRule { direction, seen, any };

class Resample {
public:
    Resample(ResampleRule rule, double error_budget_px);

    /// Writes colour and origin of every pixel. Eyes have one size; their depth_m is not read. Where an eye has moved,
    /// ResampleRule::seen needs the source's depth. `depth` has a layer for each eye, of whose corner at 0, 0 the eye's
    /// size is read. What comes after may sample, copy, draw over or write the targets without a barrier of its own.
    void reproject(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes,
                   const EyeDepth& depth, const EyeTargets& targets);

private:
    void draw_first(const EyeTargets& targets) const;

    ResampleRule rule_;
    double error_budget_px_;
    Program first_;   ///< every pixel, where the rule is simple
    Program listed_;  ///< the others, by the whole rule
    VertexArray no_vertices_;
    EyeBlocks eyes_;
    PixelList list_;
};

}  // namespace equistream::gl
