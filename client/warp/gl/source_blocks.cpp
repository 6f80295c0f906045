#include "source_blocks.h"

#include <client/warp/source_lattice.h>

#include <array>

namespace equistream::gl {

namespace {

/// As source_block.glsl has it.
struct SourceBlock {
    std::array<float, 4> cone;
    std::array<float, 2> inverses;
    float sine;
    GLuint sum;
};

}  // namespace

SourceBlocks::SourceBlocks() : pass_({{GL_COMPUTE_SHADER, "source_blocks.glsl"}}) {}

void SourceBlocks::size_for(const Camera& camera) {
    constexpr int side = LatticeBlock::side;
    const int columns = width_of(camera) + (columns_close(camera) ? 0 : 1), rows = height_of(camera) + 1;
    const Size grid{(columns + side - 1) / side, (rows + side - 1) / side};
    if (grid == grid_)
        return;
    grid_ = grid;
    blocks_ = make_buffer(std::size_t(grid.width) * std::size_t(grid.height) * sizeof(SourceBlock), 0);
}

void SourceBlocks::find() const {
    bind(pass_, 0);
    pass_.use();
    glDispatchCompute(GLuint(grid_.width), GLuint(grid_.height), 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void SourceBlocks::bind(const Program& program, GLuint binding) const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, blocks_.name());
    program.set("block_grid", glm::ivec2(grid_.width, grid_.height));
}

}  // namespace equistream::gl
