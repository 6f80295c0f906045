#pragma once
/// What gap pixels see where the eyes have no depth of their own but that which an engine found (an R32F texture of 1 /
/// planar depth, NaN for gaps): drawn forward from the pictures that fill passes look up in, as forward_depth.h has it,
/// or the background's, as background_depth.h has it. For all eyes at once; nothing is drawn where no gaps are left.
#include "gap_resample.h"
#include "patch_resample.h"

namespace equistream::gl {

class FoundDepth {
public:
    FoundDepth();

    /// All samples of a picture with depth.
    void draw_forward(const OtherPicture& from, const GapTargets& to);
    /// Those of an earlier picture whose surface is still there: the main one, of the same camera and with depth, does
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

}  // namespace equistream::gl
