#include "surface_colours.h"

#include <depth/base_colour.h>
#include <depth/base_textures.h>

#include <equistream/formatted.h>

#include <glm/vec4.hpp>

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>
#include <utility>

namespace equistream::gl {

namespace {

constexpr int page_side = BaseTextures::longest_side;

/// As surface_colours.glsl has them.
struct Surface {
    glm::vec3 base_colour;
    std::uint32_t texture, is_matte;
};
struct TextureRecord {
    std::uint32_t first_level, level_count, wrap_u, wrap_v;
};
struct LevelRecord {
    std::int32_t x, y, page, width, height;
};
static_assert(sizeof(Surface) == 20 && sizeof(LevelRecord) == 20);

const Material& material_of(const SceneModel& model, const Mesh& mesh) {
    return model.materials[mesh.material == no_index ? model.materials.size() - 1 : mesh.material];
}

Surface surface_of(const SceneModel& model, const Mesh& mesh) {
    const Material& material = material_of(model, mesh);
    return {material.base_colour, mesh.uvs.empty() ? no_index : material.base_colour_texture, is_matte(material)};
}

/// Rectangles in rows on pages, as they come: the highest first waste least.
class Shelves {
public:
    LevelRecord place(int width, int height) {
        if (x_ + width > page_side) {
            x_ = 0;
            y_ += row_height_;
            row_height_ = 0;
        }
        if (y_ + height > page_side) {
            x_ = y_ = row_height_ = 0;
            ++page_;
        }
        const LevelRecord placed{x_, y_, page_, width, height};
        x_ += width;
        row_height_ = std::max(row_height_, height);
        return placed;
    }
    int pages() const { return page_ + 1; }

private:
    int x_ = 0, y_ = 0, page_ = 0, row_height_ = 0;
};

}  // namespace

SurfaceColours::SurfaceColours(const SceneModel& model) {
    std::vector<glm::vec2> uvs;
    // One after the other as cluster_meshes has the positions: of meshes that have triangles.
    for (const Mesh& mesh : model.meshes) {
        if (mesh.triangles.empty())
            continue;
        uvs.insert(uvs.end(), mesh.uvs.begin(), mesh.uvs.end());
        uvs.resize(uvs.size() + mesh.positions.size() - mesh.uvs.size());
    }
    std::vector<Surface> surfaces;
    for (const Instance& instance : model.instances)
        surfaces.push_back(surface_of(model, model.meshes[instance.mesh]));
    uvs_ = make_buffer_of(std::span<const glm::vec2>(uvs));
    surfaces_ = make_buffer_of(std::span<const Surface>(surfaces));
    upload_textures(model);
}

void SurfaceColours::upload_textures(const SceneModel& model) {
    const BaseTextures textures(model);
    std::vector<std::uint8_t> shown(model.textures.size());
    for (const Instance& instance : model.instances)
        if (const std::uint32_t texture = surface_of(model, model.meshes[instance.mesh]).texture; texture != no_index)
            shown[texture] = 1;
    std::vector<TextureRecord> records;
    std::vector<const BaseTextures::Level*> all;
    for (std::uint32_t i = 0; i < model.textures.size(); ++i) {
        if (shown[i] != 0)
            textures.decode(i);
        const std::span<const BaseTextures::Level> levels = textures.levels(i);
        records.push_back({std::uint32_t(all.size()), std::uint32_t(levels.size()),
                           std::uint32_t(model.textures[i].wrap_u), std::uint32_t(model.textures[i].wrap_v)});
        for (const BaseTextures::Level& level : levels)
            all.push_back(&level);
    }
    std::vector<std::size_t> highest_first(all.size());
    std::iota(highest_first.begin(), highest_first.end(), std::size_t{0});
    std::ranges::stable_sort(highest_first, std::ranges::greater{}, [&](std::size_t i) { return all[i]->height; });
    std::vector<LevelRecord> places(all.size());
    Shelves shelves;
    for (const std::size_t i : highest_first)
        places[i] = shelves.place(all[i]->width, all[i]->height);
    pages_ = make_layered_texture({page_side, page_side}, shelves.pages(), GL_SRGB8_ALPHA8);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const LevelRecord& at = places[i];
        glTextureSubImage3D(pages_.name(), 0, at.x, at.y, at.page, at.width, at.height, 1, GL_RGB, GL_UNSIGNED_BYTE,
                            all[i]->rgb.data());
    }
    constexpr GLint usual_alignment = 4;
    glPixelStorei(GL_UNPACK_ALIGNMENT, usual_alignment);
    textures_ = make_buffer_of(std::span<const TextureRecord>(records));
    levels_ = make_buffer_of(std::span<const LevelRecord>(places));
}

void SurfaceColours::bind() const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, uvs_.name());
    for (const auto& [block, buffer] : {std::pair{5u, &surfaces_}, {6u, &textures_}, {7u, &levels_}})
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, block, buffer->name());
    glBindTextureUnit(4, pages_.name());
}

std::vector<std::string> SurfaceColours::defines() {
    return {formatted("FARTHEST_UV %.9g", double(BaseTextures::farthest_coordinate)),
            formatted("LEAST_AREA_M2 %.9g", double(least_triangle_m2)),
            formatted("LEAST_SEEN_COSINE %.9g", double(least_seen_cosine)),
            formatted("NO_TEXTURE 0x%xu", no_index),
            formatted("WRAP_CLAMP %du", int(Wrap::clamp)),
            formatted("WRAP_MIRROR %du", int(Wrap::mirror))};
}

}  // namespace equistream::gl
