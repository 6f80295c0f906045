#pragma once
/// Fill pass `patches` (fill.h) on the GPU, for all eyes at once, under gap_resample.h's conditions.
#include "gap_resample.h"

#include <client/fill/fill.h>

#include <cstdint>
#include <vector>

namespace equistream::gl {

/// Of the sphere at one of an atlas' offsets.
Pose patch_sphere_pose(const PatchesView& patches, int offset);

/// A frame's patches on the GPU, as SourceTextures are a picture.
class PatchTextures {
public:
    /// The view's pixels are read before this returns. Storage is kept as long as sizes stay.
    void upload(const PatchesView& patches, const PqView& pq = {});

    SourceTextures& atlas() { return atlas_; }
    const SourceTextures& atlas() const { return atlas_; }
    GLuint grid() const { return sphere_.grid(); }  ///< of the spheres that the patches are of
    GLuint slots() const { return slots_.name(); }  ///< as gap_samples.glsl has them

private:
    SourceTextures atlas_, sphere_;
    Size blocks_;
    int offsets_ = 0;
    Texture slots_;
    std::vector<std::int32_t> slot_numbers_;
};

class PatchResample {
public:
    PatchResample();

    /// Each eye takes first what is not mixed with what stands before it, and of the patches of the spheres around
    /// first those of the one nearest to it. Patches without depth fill nothing.
    void fill(const PatchesView& patches, const PatchTextures& textures, const GapTargets& to);

private:
    Program program_;
    EyeBlocks blocks_;
};

}  // namespace equistream::gl
