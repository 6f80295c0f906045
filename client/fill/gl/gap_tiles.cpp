#include "gap_tiles.h"

#include <client/fill/push_pull_pyramid.h>

#include <equistream/error.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

constexpr int levels = PullPyramid::tile_levels + 1;
constexpr int lists = 2;

/// What stands before the lists, as gap_tiles.glsl has it.
struct ListsHead {
    std::array<std::array<GLuint, 4>, lists * levels> groups;
    std::array<GLuint, lists> counts;
    glm::ivec2 grid;
};

ListsHead nothing_listed(Size grid) {
    ListsHead head{};
    head.grid = {grid.width, grid.height};
    for (auto& groups : head.groups)
        groups = {0, 1, 1, 0};
    return head;
}

}  // namespace

GapTiles::GapTiles(Of of)
    : find_({{GL_COMPUTE_SHADER, "find_gap_tiles.glsl"}},
            std::vector<std::string>{of == Of::gaps ? "COUNTS(origin) ((origin) == ORIGIN_GAP)"
                                                    : "COUNTS(origin) ((origin) != ORIGIN_SOURCE)"}),
      list_({{GL_COMPUTE_SHADER, "list_gap_tiles.glsl"}}) {}

void GapTiles::size_for(const EyeTargets& targets) {
    constexpr int side = PullPyramid::tile_side;
    const Size grid{(targets.size().width + side - 1) / side, (targets.size().height + side - 1) / side};
    if (grid == grid_ && targets.eyes() == eyes_)
        return;
    const std::size_t tiles = std::size_t(grid.width) * std::size_t(grid.height) * std::size_t(targets.eyes());
    GLint max_groups = 0;
    glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &max_groups);
    if (tiles > 4 * std::size_t(max_groups))
        throw WorkError(expected_found("OpenGL",
                                       "eyes of up to " + std::to_string(4 * std::size_t(max_groups)) +
                                           " squares of 8x8 pixels, as the driver has work groups",
                                       std::to_string(tiles)));
    states_ = make_buffer(tiles * sizeof(GLuint), 0);
    lists_ = make_buffer(sizeof(ListsHead) + lists * tiles * sizeof(GLuint), GL_DYNAMIC_STORAGE_BIT);
    grid_ = grid;
    eyes_ = targets.eyes();
}

void GapTiles::find(const EyeTargets& targets) {
    size_for(targets);
    const ListsHead nothing = nothing_listed(grid_);
    // The last lists were written by a shader.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glNamedBufferSubData(lists_.name(), 0, sizeof nothing, &nothing);
    bind();
    glBindTextureUnit(0, targets.origin());
    for (const Program* program : {&find_, &list_}) {
        program->dispatch(grid_, eyes_);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    }
}

void GapTiles::bind() const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, states_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, lists_.name());
}

void GapTiles::dispatch(const Program& program, List list, int shift) const {
    program.dispatch_indirect(lists_.name(), sizeof(ListsHead::groups[0]) * std::size_t(int(list) * levels + shift));
}

}  // namespace equistream::gl
