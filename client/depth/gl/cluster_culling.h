#pragma once
/// Which clusters views may see, found on the GPU by what hides them.
#include "scene_geometry.h"

#include <client/gpu/program.h>

#include <cstdint>

namespace equistream::gl {

// What hides what lies behind it: the farthest depth over squares of a view, in coarser and coarser levels (Greene,
// Kass and Miller 1993, "Hierarchical Z-buffer visibility"). Values are DepthPass's: near / planar depth, 0 for a
// miss.

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

// Which clusters views may see, found on the GPU: a list of draws for each of two rounds, and what every draw's
// vertices need to know.

/// What is left out of a draw. Depth is the same with each.
enum class Culling {
    nothing,  ///< every view draws every triangle, as the paper's client does
    outside,  ///< clusters that lie beside a view
    hidden,   ///< those, and clusters behind what is nearer; best where views change little from draw to draw
};

struct DrawnFigures {
    std::uint32_t draws = 0;      ///< clusters times views
    std::uint32_t triangles = 0;  ///< times views
};

class ClusterCulling {
public:
    /// `geometry` outlives it.
    explicit ClusterCulling(const SceneGeometry& geometry);

    /// For so many layers of that size. Throws WorkError where the driver has no storage for it.
    void size_for(Size size, int layers);

    /// A new frame of so many views, which depth_views.glsl's block describes; nothing is drawn of it.
    void start(int views, Culling culling);
    /// Lists what is drawn in a round, first all that is drawn but where what is hidden is culled.
    void find(int round) const;
    /// After that was drawn into `depth`, the rest; only where what is hidden is culled.
    void find_rest(const Texture& depth) const;

    /// The listed clusters of a round, with masks or without: of the vertices that are bound.
    void draw(int round, bool masked) const;

    /// A record for each draw, as DrawRecord of cull.glsl, for its instance.
    GLuint records() const { return records_.name(); }
    static constexpr GLsizei record_bytes = 64;
    static constexpr int rounds(Culling culling) { return culling == Culling::hidden ? 2 : 1; }

    /// Of the last frame; waits for the GPU.
    DrawnFigures drawn() const;

private:
    const SceneGeometry& geometry_;
    Program program_;
    DepthPyramid pyramid_;
    Buffer counts_, seen_by_, records_, opaque_commands_, masked_commands_;
    int layers_ = 0, views_ = 0;
    Culling culling_ = Culling::hidden;
};

}  // namespace equistream::gl
