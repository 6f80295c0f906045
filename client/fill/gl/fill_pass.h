#pragma once
/// Passes of the fill chain (fill.h) on the GPU, and the depth they look up by.
#include "gap_resample.h"

#include <client/fill/fill.h>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream::gl {

// What gap pixels see where the eyes have no depth of their own but that which an engine found (an R32F texture of 1 /
// planar depth, NaN for gaps): drawn forward from the pictures that fill passes look up in (see forward_depth.h),
// or the background's (see gaps.h). For all eyes at once; nothing is drawn where no gaps are left.

class FoundDepth {
public:
    FoundDepth();

    /// All samples of a picture with depth.
    void draw_forward(const OtherPicture& from, const GapTargets& to);
    /// Those of an earlier picture whose surface is still there: the main one, with depth and of any camera, does
    /// not look through it.
    void draw_still_there(const OtherPicture& earlier, const OtherPicture& main, const GapTargets& to);
    /// Of all spheres.
    void draw_forward(const PatchesView& patches, const PatchTextures& textures, const GapTargets& to);
    /// Of gaps, nothing: what was drawn forward into them from another picture is none of the next one's.
    void forget(const GapTargets& to);
    /// What gaps see that nothing else fills: their background.
    void find_background(const SourceView& main, const GapTargets& to);

private:
    void start(const GapTargets& to, GLuint depth);
    void draw_picture(const OtherPicture& from, const GapTargets& to, GLuint depth);
    void count_groups(Size samples, int layers, const GapTargets& to) const;
    void end(const GapTargets& to);
    void size_for(const EyeTargets& targets);

    Program draw_, draw_patches_, end_, groups_pass_, still_there_, background_;
    EyeBlocks blocks_;
    Size size_, earlier_size_;
    int eyes_ = 0;
    Texture keys_, earlier_depth_;
    Buffer groups_;  ///< of the next pass over samples
};

// Passes of the fill chain (fill.h) on the GPU, for all eyes at once. A pass is its own files and a row of
// client/stages/stage_rows.inc.

/// What eyes see of the sphere around their window alone; their depth, or texture 0: they see it by direction.
struct SeenBase {
    const EyeTargets& targets;
    EyeDepth depth;
};

/// A window that the gaze has left.
struct LeftPicture {
    OtherPicture window;
    OtherPicture base;  ///< the sphere around it: by these it shows where light has changed
    SpecularSource mirrors;
};

/// What a frame brings to fill gaps with, borrowed for a call.
struct GlFillFrame {
    OtherPicture main;  ///< as the eyes look it up
    std::optional<OtherPicture> base, hidden, small, earlier;
    std::span<const LeftPicture> left{};
    /// Draws what eyes see of `base` alone, by the engine that shows the main picture.
    std::function<SeenBase()> see_base{};
    const PatchesView* patches = nullptr;
    const PatchTextures* patch_textures = nullptr;
    /// Finds what gap pixels see where eyes have no depth of their own; null: they have, by the scene's geometry.
    FoundDepth* found = nullptr;
    SpecularSource mirrors;                         ///< what the main picture tells of mirrors and glass
    std::optional<SpecularSource> mirrors_earlier;  ///< the same of the earlier picture
    GapMirrors* gap_mirrors = nullptr;
};

/// Programs that several passes run: made once, when the first of them is.
class GlFillShared {
public:
    GapResample& resample();

private:
    std::optional<GapResample> resample_;
};

class GlFillPass {
public:
    virtual ~GlFillPass() = default;
    virtual std::string_view name() const = 0;
    /// A pass whose input is missing fills nothing.
    virtual void fill(const GlFillFrame& frame, const GapTargets& to) = 0;
};

using GlFillChain = std::vector<std::unique_ptr<GlFillPass>>;

/// Of a comma-separated list, in its order; "none" alone: no pass. `shared` outlives the chain. Throws InputError that
/// names the accepted words.
GlFillChain make_gl_fill_chain(const std::string& list, GlFillShared& shared);

/// The list with what stands for the passes that the CPU alone has: `small` for `small-wide`, `pushpull` for `spread`,
/// nothing for `geometry`. Adds a line to `notes` for each.
std::string with_passes_of_gpu(const std::string& list, std::vector<std::string>& notes);

}  // namespace equistream::gl
