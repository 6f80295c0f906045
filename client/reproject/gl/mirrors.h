#pragma once
/// rework_specular (specular.h) on the GPU, for all eyes at once.
#include "eye_blocks.h"
#include "eye_targets.h"
#include "source_textures.h"

#include <equistream_client/specular.h>

#include <span>

namespace equistream::gl {

class Mirrors {
public:
    Mirrors();

    /// The source's mask and virtual depth, where it has them; their pixels are read before this returns. Storage is
    /// kept as long as its size stays.
    void upload(const SourceView& source);
    /// After an engine's reproject; `view` is that of the last upload, of whose colour and depth `source` knows.
    /// Without mask or depth nothing is done, nor by MirrorTreatment::surface. What comes after needs no barrier of its
    /// own, as in LookUp.
    void rework(const SourceView& view, const SourceTextures& source, std::span<const EyeView> eyes,
                const EyeDepth& depth, const EyeTargets& targets, MirrorTreatment treatment = MirrorTreatment::images);

private:
    Program program_;
    EyeBlocks blocks_;
    Size size_;
    bool has_mask_ = false;
    Texture specular_, virtual_depth_;
};

}  // namespace equistream::gl
