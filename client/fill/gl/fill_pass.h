#pragma once
/// Passes of the fill chain (fill.h) on the GPU, for all eyes at once. A pass is its own files and a row of
/// client/stages/stage_rows.inc.
#include "found_depth.h"
#include "gap_mirrors.h"
#include "gap_resample.h"
#include "patch_resample.h"

#include <client/fill/fill.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace equistream::gl {

/// What a frame brings to fill gaps with, borrowed for a call.
struct GlFillFrame {
    OtherPicture main;  ///< as the eyes look it up
    std::optional<OtherPicture> hidden, small, earlier;
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
