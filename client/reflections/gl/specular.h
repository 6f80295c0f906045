#pragma once
/// Mirrors and glass (client/reflections/specular.h) on the GPU.
#include <client/reflections/specular.h>
#include <client/warp/gl/eye_targets.h>
#include <client/warp/gl/source_textures.h>
#include <client/warp/view.h>

#include <span>

namespace equistream::gl {

// Where a source picture shows mirrors and glass, and how far away the images in them are, on the GPU: one upload a
// picture for whoever asks. The context it was made in is current in every call.

class SpecularTextures {
public:
    /// The source's mask and virtual depth, where it has them; their pixels are read before this returns. Storage is
    /// kept as long as its size stays.
    void upload(const SourceView& source);
    /// For a pass that makes both here, of such a size; `has_mask`: otherwise there are none.
    void size_for(Size size, bool has_mask);

    bool has_mask() const { return has_mask_; }
    /// For shaders that include mirror_planes.glsl: texture units 6 and 7. Only with a mask.
    void bind() const;
    GLuint mask() const { return mask_.name(); }                    ///< GL_R32F, 0 to 1
    GLuint virtual_depth() const { return virtual_depth_.name(); }  ///< GL_R32F; NaN where nobody has told

private:
    Size size_;
    bool has_mask_ = false;
    Texture mask_, virtual_depth_;
};

/// A source with its mirrors: `specular` is of the same picture as `textures`.
struct SpecularSource {
    const SourceView& view;
    const SourceTextures& textures;
    const SpecularTextures& specular;

    /// Whether it says where mirrors are, and how far they are.
    bool tells() const { return specular.has_mask() && textures.depth() != 0; }
};

// rework_specular on the GPU, for all eyes at once.

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
