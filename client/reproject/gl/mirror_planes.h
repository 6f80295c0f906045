#pragma once
/// What a picture says of mirrors and glass, on the GPU.
#include "source_textures.h"

namespace equistream::gl {

class MirrorPlanes {
public:
    /// The picture's mask and virtual depth, where it has them; their pixels are read before this returns. Storage is
    /// kept as long as its size stays.
    void upload(const SourceView& source);

    bool has_mask() const { return has_mask_; }
    /// For shaders that include mirror_planes.glsl: texture units 6 and 7. Only with a mask.
    void bind() const;

private:
    Size size_;
    bool has_mask_ = false;
    Texture specular_, virtual_depth_;
};

/// A picture that may have a mask: what it is of, its pixels and what it says of mirrors.
struct MirroringPicture {
    const SourceView& view;
    const SourceTextures& textures;
    const MirrorPlanes& planes;

    /// Whether it says where mirrors are, and how far they are.
    bool tells() const { return planes.has_mask() && textures.depth() != 0; }
};

}  // namespace equistream::gl
