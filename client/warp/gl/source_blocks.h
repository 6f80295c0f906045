#pragma once
/// How near and how far blocks of a source's lattice show something, in which directions, and whether their samples are
/// still the same (source_block.glsl).
#include <client/gpu/objects.h>
#include <client/gpu/program.h>

#include <equistream/camera.h>

namespace equistream::gl {

class SourceBlocks {
public:
    SourceBlocks();

    /// Storage is kept as long as there are as many.
    void size_for(const Camera& camera);
    /// Of the depth of a source that EyeDepthFinder::bind has bound. What comes after may read them without a barrier
    /// of its own.
    void find() const;
    /// For a program that reads them at this binding.
    void bind(const Program& program, GLuint binding) const;

    int count() const { return grid_.width * grid_.height; }
    Size grid() const { return grid_; }

private:
    Program pass_;
    Size grid_;
    Buffer blocks_;
};

}  // namespace equistream::gl
