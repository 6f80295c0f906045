#include "gap_resample.h"

#include <equistream/patches.h>

#include <client/fill/push_pull.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace equistream::gl {

namespace {

constexpr int levels = PullPyramid::tile_levels + 1;
constexpr int lists = 2;

/// What stands before the lists (see gap_tiles.glsl).
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
    : GapTiles(Program("find_gap_tiles.glsl",
                       std::vector<std::string>{of == Of::gaps ? "COUNTS(origin) ((origin) == ORIGIN_GAP)"
                                                               : "COUNTS(origin) ((origin) != ORIGIN_SOURCE)"})) {}

GapTiles::GapTiles(Program find) : find_(std::move(find)), list_("list_gap_tiles.glsl") {}

void GapTiles::size_for(const EyeTargets& targets) {
    constexpr int side = PullPyramid::tile_side;
    const Size grid{(targets.size().width + side - 1) / side, (targets.size().height + side - 1) / side};
    if (grid == grid_ && targets.eyes() == eyes_)
        return;
    const std::size_t tiles = std::size_t(grid.width) * std::size_t(grid.height) * std::size_t(targets.eyes());
    grid_ = {};  // what fails half-way is begun anew
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

void GapTiles::draw_points(List list) const {
    // Of tiles alone there are no more groups than fit into a row: vertices, an instance, and the first vertex.
    static_assert(sizeof(ListsHead::groups[0]) == 4 * sizeof(GLuint));
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, lists_.name());
    // From a buffer that is bound there, Mesa takes a number of draws for this call as well.
    glBindBuffer(GL_PARAMETER_BUFFER_ARB, 0);
    glDrawArraysIndirect(GL_POINTS,
                         reinterpret_cast<const void*>(sizeof(ListsHead::groups[0]) * std::size_t(int(list) * levels)));
}

GapResample::GapResample() : program_("gap_resample.glsl") {}

void GapResample::fill(const OtherPicture& from, const GapTargets& to) {
    const bool by_direction = from.textures.depth() == 0 || to.depth.texture == 0;
    if (by_direction && from.mark != PixelOrigin::small)
        return;
    blocks_.set(from.view, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, from.textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    glBindTextureUnit(0, from.textures.colour());
    glBindTextureUnit(1, from.textures.depth());
    program_.set("by_direction", int(by_direction));
    run_gap_resample(program_, to, from.mark);
}

void run_gap_resample(const Program& program, const GapTargets& to, PixelOrigin mark) {
    assert(int(to.eyes.size()) == to.targets.eyes());
    to.gaps.bind();
    glBindTextureUnit(2, to.depth.texture);
    glBindTextureUnit(3, to.targets.origin());
    glBindTextureUnit(5, to.image_behind);
    glBindTextureUnit(8, to.light_then);
    glBindTextureUnit(9, to.light_now);
    glBindImageTexture(0, to.targets.colour(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    glBindImageTexture(1, to.targets.origin(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
    program.set("inverse_depth_scale", to.depth.scale);
    program.set("mark", int(mark));
    program.set("knows_mirrors", int(to.image_behind != 0));
    program.set("knows_light", int(to.light_then != 0 && to.light_now != 0));
    to.gaps.dispatch(program, GapTiles::List::with_gaps, PullPyramid::tile_levels);
    finish_pictures();
}

GapMirrors::GapMirrors() : program_("gap_mirrors.glsl") {}

GLuint GapMirrors::find(const SpecularSource& teller, const GapTargets& to) {
    assert(int(to.eyes.size()) == to.targets.eyes());
    if (!teller.tells())
        return 0;
    if (!(to.targets.size() == size_ && to.targets.eyes() == eyes_)) {
        image_behind_ = make_layered_texture(to.targets.size(), to.targets.eyes(), GL_R32F);
        size_ = to.targets.size();
        eyes_ = to.targets.eyes();
    }
    blocks_.set(teller.view, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, teller.textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    to.gaps.bind();
    glBindTextureUnit(1, teller.textures.depth());
    glBindTextureUnit(2, to.depth.texture);
    glBindTextureUnit(3, to.targets.origin());
    teller.specular.bind();
    glBindImageTexture(0, to.targets.colour(), 0, GL_TRUE, 0, GL_READ_ONLY, GL_RGBA8);
    glBindImageTexture(2, image_behind_.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    program_.set("inverse_depth_scale", to.depth.scale);
    to.gaps.dispatch(program_, GapTiles::List::with_gaps, PullPyramid::tile_levels);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return image_behind_.name();
}

SeenLight::SeenLight() : program_("seen_light.glsl") {}

void SeenLight::size_for(const EyeTargets& targets) {
    if (targets.size() == size_ && targets.eyes() == eyes_)
        return;
    for (Texture* light : {&then_, &now_})
        *light = make_layered_texture(targets.size(), targets.eyes(), GL_RGBA8);
    size_ = targets.size();
    eyes_ = targets.eyes();
}

void SeenLight::look_up(const OtherPicture& picture, const GapTargets& to, const Texture& light) {
    blocks_.set(picture.view, to.eyes);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, picture.textures.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
    glBindTextureUnit(0, picture.textures.colour());
    glBindImageTexture(0, light.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
    to.gaps.dispatch(program_, GapTiles::List::with_gaps, PullPyramid::tile_levels);
}

void SeenLight::find(const OtherPicture& then, const OtherPicture& now, GapTargets& to) {
    assert(int(to.eyes.size()) == to.targets.eyes() && to.depth.texture != 0);
    size_for(to.targets);
    to.gaps.bind();
    glBindTextureUnit(2, to.depth.texture);
    glBindTextureUnit(3, to.targets.origin());
    program_.set("inverse_depth_scale", to.depth.scale);
    look_up(then, to, then_);
    look_up(now, to, now_);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    to.light_then = then_.name();
    to.light_now = now_.name();
}

namespace {

using SphereOrder = std::array<int, max_patch_offsets>;

/// What the eye sees is seen most alike from the sphere that is nearest to it.
SphereOrder nearest_first(const PatchesView& patches, const EyeView& eye) {
    SphereOrder order{};
    const std::size_t count = patches.atlas->offsets_m.size();
    assert(count <= order.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(std::span(order).first(count), {}, [&](int offset) {
        return glm::distance(patch_sphere_pose(patches, offset).position_m, eye.pose.position_m);
    });
    return order;
}

}  // namespace

Pose patch_sphere_pose(const PatchesView& patches, int offset) {
    const Pose& pose = patches.pose;
    return {pose.position_m + pose.orientation * patches.atlas->offsets_m[std::size_t(offset)], pose.orientation};
}

void PatchTextures::upload(const PatchesView& patches, const PqView& pq) {
    const PatchAtlas& atlas = *patches.atlas;
    sphere_.describe(atlas.sphere());
    // Its pixels are looked up by number, whatever a camera would make of them.
    atlas_.upload({.rgb = patches.rgb,
                   .yuv = patches.yuv,
                   .camera = EquirectCamera{atlas.width(), atlas.height(), {}},
                   .depth_m = patches.depth_m},
                  pq);
    const Size blocks{atlas.block_columns(), atlas.block_rows()};
    const int offsets = int(atlas.offsets_m.size());
    if (!(blocks == blocks_) || offsets != offsets_) {
        slots_ = make_layered_texture(blocks, offsets, GL_R32I);
        blocks_ = blocks;
        offsets_ = offsets;
    }
    const std::size_t of_sphere = std::size_t(blocks.width) * std::size_t(blocks.height);
    slot_numbers_.assign(of_sphere * std::size_t(offsets), -1);
    // Of a block that is in two slots the first counts (PatchSlots).
    for (std::size_t i = atlas.slots.size(); i-- > 0;)
        if (const PatchAtlas::Slot& slot = atlas.slots[i]; slot.used)
            slot_numbers_[slot.offset_index * of_sphere + std::size_t(slot.block_y) * std::size_t(blocks.width) +
                          slot.block_x] = std::int32_t(i);
    glTextureSubImage3D(slots_.name(), 0, 0, 0, 0, blocks.width, blocks.height, offsets, GL_RED_INTEGER, GL_INT,
                        slot_numbers_.data());
}

PatchResample::PatchResample() : program_("gap_resample.glsl", std::vector<std::string>{"PATCHES"}) {}

void PatchResample::fill(const PatchesView& patches, const PatchTextures& textures, const GapTargets& to) {
    if (textures.atlas().depth() == 0)
        return;
    const PatchAtlas& atlas = *patches.atlas;
    const std::size_t eyes = to.eyes.size();
    std::array<SphereOrder, max_eyes> order;
    for (std::size_t eye = 0; eye < eyes; ++eye)
        order[eye] = nearest_first(patches, to.eyes[eye]);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, textures.grid());
    glBindTextureUnit(0, textures.atlas().colour());
    glBindTextureUnit(1, textures.atlas().depth());
    glBindTextureUnit(4, textures.slots());
    program_.set("block_side", atlas.block_side);
    program_.set("slot_columns", atlas.columns);
    for (const bool unmixed_only : {true, false})
        for (std::size_t i = 0; i < atlas.offsets_m.size(); ++i) {
            static_assert(max_eyes == 2);
            const glm::ivec2 spheres(order[0][i], order[eyes - 1][i]);
            const std::array<Pose, max_eyes> poses = {patch_sphere_pose(patches, spheres[0]),
                                                      patch_sphere_pose(patches, spheres[1])};
            blocks_.set(std::span(poses).first(eyes), patches.box_radius_m, to.eyes);
            glBindBufferBase(GL_UNIFORM_BUFFER, 1, blocks_.name());
            program_.set("patch_spheres", spheres);
            program_.set("unmixed_only", int(unmixed_only));
            run_gap_resample(program_, to, PixelOrigin::patches);
        }
}

}  // namespace equistream::gl
