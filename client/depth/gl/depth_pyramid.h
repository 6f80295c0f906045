#pragma once
/// What hides what lies behind it: the farthest depth over squares of a view, in coarser and coarser levels (Greene,
/// Kass and Miller 1993, "Hierarchical Z-buffer visibility"). Values are DepthPass's: near / planar depth, 0 for a
/// miss.
#include <client/gpu/program.h>

namespace equistream::gl {

class DepthPyramid {
public:
    /// Texels of a view along a side of a texel of level 0; shaders get it as PYRAMID_BLOCK.
    static constexpr int block = 8;

    explicit DepthPyramid(std::span<const std::string> defines);

    /// For layers of this size. Throws WorkError where the driver has no storage for it.
    void size_for(Size size, int layers);

    /// From the first `layers` of `depth`; the block of views that depth_views.glsl describes is bound.
    void build(const Texture& depth, int layers) const;

    GLuint texture() const { return levels_.name(); }

private:
    Program program_;
    Texture levels_;
    Size size_;
    int level_count_ = 0;
};

}  // namespace equistream::gl
