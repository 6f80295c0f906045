#include "push_pull.h"

#include <client/fill/push_pull.h>

#include <cassert>
#include <string>

namespace equistream::gl {

namespace {

using List = GapTiles::List;

const std::vector<std::string> tiled = {"TILED"};

constexpr GLuint beside_unit = 3, own_unit = 4;

void write_to(const Texture& layers) {
    glBindImageTexture(0, layers.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
}

void finish_level() {
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace

PushPull::PushPull()
    : pull_pixels_("pull_pixels.glsl"), pull_tiles_("pull_cells.glsl", tiled), pull_cells_("pull_cells.glsl"),
      push_tiles_("push_cells.glsl", tiled), push_cells_("push_cells.glsl"), push_pixels_("push_pixels.glsl") {}

void PushPull::size_for(Size tiles, int eyes) {
    if (tiles == tiles_ && eyes == eyes_)
        return;
    tiles_ = {};  // what fails half-way is begun anew
    levels_.clear();
    const auto add = [&](int columns, int rows, int tile_shift) {
        levels_.push_back({{columns, rows, tile_shift}, make_layered_texture({columns, rows}, 2 * eyes, GL_RGBA32F)});
    };
    for (int shift = PullPyramid::tile_levels - 1; shift >= 0; --shift)
        add(tiles.width << shift, tiles.height << shift, shift);
    for (int columns = tiles.width, rows = tiles.height; columns > 1 || rows > 1;) {
        columns = (columns + 1) / 2;
        rows = (rows + 1) / 2;
        add(columns, rows, -1);
    }
    tiles_ = tiles;
    eyes_ = eyes;
}

void PushPull::pull(const GapTiles& gaps) const {
    for (std::size_t i = 0; i < levels_.size(); ++i) {
        const glm::ivec3 cells = levels_[i].cells;
        const bool in_tiles = cells.z >= 0;
        const Program& program = i == 0 ? pull_pixels_ : in_tiles ? pull_tiles_ : pull_cells_;
        program.set("level", cells);
        write_to(levels_[i].layers);
        if (i > 0)
            glBindTextureUnit(beside_unit, levels_[i - 1].layers.name());
        if (!in_tiles)
            program.set("finer", levels_[i - 1].cells);
        if (in_tiles)
            gaps.dispatch(program, List::with_gaps_or_beside, cells.z);
        else
            program.dispatch({cells.x, cells.y}, eyes_);
        finish_level();
    }
}

void PushPull::push(const GapTiles& gaps) const {
    for (std::size_t i = levels_.size() - 1; i-- > 0;) {
        const glm::ivec3 cells = levels_[i].cells;
        const bool in_tiles = cells.z >= 0;
        const Program& program = in_tiles ? push_tiles_ : push_cells_;
        program.set("level", cells);
        program.set("coarser", levels_[i + 1].cells);
        glBindTextureUnit(own_unit, levels_[i].layers.name());
        glBindTextureUnit(beside_unit, levels_[i + 1].layers.name());
        write_to(levels_[i].layers);
        if (in_tiles)
            gaps.dispatch(program, List::with_gaps, cells.z);
        else
            program.dispatch({cells.x, cells.y}, eyes_);
        finish_level();
    }
}

void PushPull::fill(const SourceView& source, std::span<const EyeView> eyes, const EyeDepth& depth,
                    const GapTiles& gaps, const EyeTargets& targets) {
    assert(int(eyes.size()) == targets.eyes());
    size_for(gaps.grid(), targets.eyes());
    blocks_.set(source, eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    gaps.bind();
    glBindTextureUnit(0, targets.colour());
    glBindTextureUnit(1, targets.origin());
    glBindTextureUnit(2, depth.texture);
    for (const Program* program : {&pull_pixels_, &push_pixels_})
        program->set("inverse_depth_scale", depth.texture != 0 ? depth.scale : 0.0f);
    pull(gaps);
    push(gaps);
    push_pixels_.set("coarser", levels_.front().cells);
    glBindTextureUnit(beside_unit, levels_.front().layers.name());
    glBindImageTexture(0, targets.colour(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(1, targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    gaps.dispatch(push_pixels_, List::with_gaps, levels_.front().cells.z);
    finish_pictures();
}

}  // namespace equistream::gl
