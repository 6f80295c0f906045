#pragma once
/// rework_specular (specular.h) on the GPU, for all eyes at once.
#include "specular_textures.h"

#include <client/reflections/specular.h>
#include <client/warp/gl/eye_blocks.h>
#include <client/warp/gl/eye_targets.h>

#include <span>

namespace equistream::gl {

class Mirrors {
public:
    Mirrors();

    /// After an engine's reproject of the picture. Without mask or depth nothing is done, nor by
    /// MirrorTreatment::surface. What comes after needs no barrier of its own, as in Resample.
    void rework(const SpecularSource& picture, std::span<const EyeView> eyes, const EyeDepth& depth,
                const EyeTargets& targets, MirrorTreatment treatment = MirrorTreatment::images);

private:
    Program program_;
    EyeBlocks blocks_;
};

}  // namespace equistream::gl
