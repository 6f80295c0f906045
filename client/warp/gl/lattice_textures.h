#pragma once
/// What source_lattice.glsl knows of a source's lattice beside its depth: the sines and cosines of its columns and
/// rows.
#include <client/gpu/objects.h>

#include <equistream/camera.h>

#include <optional>

namespace equistream::gl {

class LatticeTextures {
public:
    /// Kept as long as the camera stays. Whether it did.
    bool set(const Camera& camera);
    /// To the unit that source_lattice.glsl reads.
    void bind() const;
    Size size() const { return size_; }  ///< of the source

private:
    std::optional<Camera> camera_;
    Size size_;
    Texture angles_;
};

}  // namespace equistream::gl
