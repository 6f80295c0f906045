#pragma once
/// The `pushpull` fill pass (fill/push_pull.h says what it computes) on the GPU, for all eyes at once.
#include "gap_resample.h"

#include <client/warp/gl/eye_targets.h>

#include <span>
#include <vector>

namespace equistream::gl {

class PushPull {
public:
    PushPull();

    /// Colours the gaps of all eyes of the targets, `source` being the main picture, whose pixels are not read. Kept
    /// apart by the eyes' depth, the background where that is not known; `depth.texture` 0: all depths are alike.
    /// `gaps` are those of the targets as they are. What comes after needs no barrier of its own, as in Resample.
    void fill(const SourceView& source, std::span<const EyeView> eyes, const EyeDepth& depth, const GapTiles& gaps,
              const EyeTargets& targets);

private:
    struct Level {
        glm::ivec3 cells{0};  ///< (see push_pull_levels.glsl)
        Texture layers;       ///< far and near ones of each eye
    };

    void size_for(Size tiles, int eyes);
    void pull(const GapTiles& gaps) const;
    void push(const GapTiles& gaps) const;

    Program pull_pixels_, pull_tiles_, pull_cells_, push_tiles_, push_cells_, push_pixels_;
    Size tiles_;
    int eyes_ = 0;
    std::vector<Level> levels_;  ///< from the one above the pixels up
    EyeBlocks blocks_;
};

}  // namespace equistream::gl
