#include "patch_resample.h"

#include <equistream/patches.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <string>

namespace equistream::gl {

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

PatchResample::PatchResample()
    : program_({{GL_COMPUTE_SHADER, "gap_resample.glsl"}}, std::vector<std::string>{"PATCHES"}) {}

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
