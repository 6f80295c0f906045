#pragma once
/// What the eyes by OpenGL stand beside: two usual ways from a sphere with depth to an eye, without masks and fill.
#include <client/gpu/program.h>
#include <client/warp/gl/eye_targets.h>
#include <client/warp/gl/source_textures.h>

#include <span>
#include <vector>

namespace equistream::bench {

/// Pictures of eyes that the peers draw; their targets are of their own.
class PeerTargets {
public:
    explicit PeerTargets(const PerspectiveCamera& camera, int eyes);

    /// Binds and clears an eye's picture.
    void begin(int eye) const;

private:
    gl::Size size_;
    gl::Texture colour_, depth_;
    std::vector<gl::Framebuffer> framebuffers_;
};

/// Every sample of a sphere, of those that may come into view, is a vertex as far away as its depth says, the triangles
/// between them a sheet without cuts.
class MeshWarp {
public:
    explicit MeshWarp(const EquirectCamera& sphere);

    void draw(const SourceView& source, const gl::SourceTextures& textures, std::span<const EyeView> eyes,
              const PeerTargets& targets);

private:
    /// What of each row of triangles to draw for an eye that looks there, in the sphere's frame.
    void find_rows(glm::vec3 ahead);

    EquirectCamera sphere_;
    gl::Program program_;
    gl::EyeBlocks blocks_;
    gl::VertexArray vertices_;
    gl::Buffer strip_;
    std::vector<GLsizei> counts_;
    std::vector<const void*> offsets_;
    std::vector<GLint> first_vertices_;
};

/// Every pixel of an eye finds its point by eight steps of a fixed point through the sphere's depth; what has not
/// settled by then is black.
class BackwardSearch {
public:
    BackwardSearch();

    void draw(const SourceView& source, const gl::SourceTextures& textures, std::span<const EyeView> eyes,
              const PeerTargets& targets);

private:
    gl::Program program_;
    gl::EyeBlocks blocks_;
    gl::VertexArray no_vertices_;
};

}  // namespace equistream::bench
