#include "obj_materials.h"

#include "file_bytes.h"
#include "model.h"
#include "obj_files.h"

#include <plugin/pictures/encoded_image.h>

#include <equistream/error.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <system_error>

namespace equistream {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t texture_size_limit = std::uint64_t{1} << 30;
constexpr glm::vec3 usual_grey{0.8f};
/// 3ds Max writes its default diffuse colour where a map replaces it.
constexpr float replaced_grey = 0.588f;

glm::vec3 colour_of(const float (&v)[3]) {
    return glm::max(glm::vec3(v[0], v[1], v[2]), glm::vec3(0));
}

bool is_black(const glm::vec3& c) {
    return c == glm::vec3(0);
}

bool is_glass_model(int illum) {
    return illum == 4 || illum == 6 || illum == 7 || illum == 9;
}

float index_of_refraction(const MtlMaterial& m) {
    return m.gives("Ni") && m.values.ior > 1 ? std::min(m.values.ior, 10.0f) : 1.5f;
}

class Converter {
public:
    Converter(const ModelOptions& options, ObjNotes& notes) : options_(options), notes_(notes) {}

    ObjMaterials convert(const std::vector<MtlMaterial>& from, const std::vector<bool>& used) {
        for (std::size_t i = 0; i < from.size(); ++i)
            add(from[i], used[i]);
        Material none;
        none.name = "(none)";
        none.base_colour = usual_grey;
        none.metallic = 0;
        none.index_of_refraction = 1;
        none.double_sided = true;
        out_.materials.push_back(none);
        out_.uv_scale.emplace_back(1);
        out_.uv_offset.emplace_back(0);
        out_.textured.push_back(false);
        return std::move(out_);
    }

private:
    void add(const MtlMaterial& from, bool used) {
        Material to;
        to.name = from.values.name;
        to.double_sided = true;
        const std::string colour_map = from.gives("map_Kd") ? "map_Kd" : "map_Ka";
        const ObjTexture placing = from.gives(colour_map) ? from.textures.at(colour_map) : ObjTexture{};
        std::uint32_t colours = no_index;
        if (used) {
            colours = image_of(from, colour_map);
            to.alpha_mask = mask_of(from, colour_map, colours);
        }
        if (options_.shading)
            shade(from, used, colours, to);
        out_.uv_scale.push_back(placing.scale);
        out_.uv_offset.push_back(placing.offset);
        out_.textured.push_back(to.base_colour_texture != no_index || to.emission_texture != no_index ||
                                to.alpha_mask != no_index);
        out_.materials.push_back(std::move(to));
    }

    void shade(const MtlMaterial& from, bool used, std::uint32_t colours, Material& to) {
        const tinyobj::material_t& m = from.values;
        const bool has_specular = from.gives("Ks") && !is_black(colour_of(m.specular)) &&
                                  !(from.gives("illum") && m.illum >= 0 && m.illum < 2);
        glm::vec3 diffuse = from.gives("Kd") ? colour_of(m.diffuse) : has_specular ? glm::vec3(0) : usual_grey;
        if (colours != no_index) {
            to.base_colour_texture = use_texture(colours, from);
            diffuse = under_texture(from.gives("Kd") ? diffuse : glm::vec3(1));
        }
        to.transmission = to.alpha_mask == no_index ? transmission_of(from, diffuse, colours != no_index) : 0;
        to.metallic = 0;
        to.roughness = from.gives("Ns") ? roughness_of_exponent(m.shininess) : 1;
        to.index_of_refraction = index_of_refraction(from);
        to.base_colour = diffuse;
        if (to.transmission > 0) {
            const glm::vec3 filter =
                from.gives("Tf") && !is_black(colour_of(m.transmittance)) ? colour_of(m.transmittance) : glm::vec3(1);
            to.base_colour = glm::mix(diffuse, filter, to.transmission);
        }
        if (from.gives("Pr") || from.gives("Pm")) {
            to.metallic = std::clamp(m.metallic, 0.0f, 1.0f);
            to.roughness = from.gives("Pr") ? std::clamp(m.roughness, 0.0f, 1.0f) : to.roughness;
        } else if (to.transmission > 0) {
            to.roughness = 0;
        } else if (!has_specular) {
            to.index_of_refraction = 1;
            to.roughness = 1;
        } else if (is_black(diffuse)) {
            to.base_colour = glm::min(colour_of(m.specular), glm::vec3(1));
            to.metallic = 1;
        }
        to.base_colour = glm::min(to.base_colour, glm::vec3(1));
        to.emission = colour_of(m.emission);
        const std::uint32_t glow = used ? image_of(from, "map_Ke") : no_index;
        if (glow != no_index) {
            to.emission_texture = use_texture(glow, from);
            to.emission = is_black(to.emission) ? glm::vec3(1) : to.emission;
        }
    }

    static glm::vec3 under_texture(const glm::vec3& diffuse) {
        const glm::vec3 off = glm::abs(diffuse - replaced_grey);
        return is_black(diffuse) || std::max({off.x, off.y, off.z}) < 0.001f ? glm::vec3(1) : diffuse;
    }

    /// What passes straight through. `d` counts before `Tr`; both at 0, or Tr alone at 1, would make things invisible
    /// that were meant to be seen: there the exporter had the numbers the other way round.
    float transmission_of(const MtlMaterial& from, const glm::vec3& diffuse, bool textured) {
        if (from.gives("illum") && is_glass_model(from.values.illum) && is_black(diffuse) && !textured)
            return 1;
        const std::string name = "\"" + from.values.name + "\"";
        if (!from.gives("d") && !from.gives("Tr"))
            return 0;
        if (!from.gives("d") && from.tr >= 1) {
            notes_.add(from.where("Tr"), "Tr 1 without d would make " + name + " invisible: taken as opaque");
            return 0;
        }
        if (from.gives("d") && from.gives("Tr") && from.values.dissolve <= 0 && from.tr <= 0) {
            notes_.add(from.where("d"), "d 0 and Tr 0 contradict each other: " + name + " is taken as opaque");
            return 0;
        }
        return 1 - std::clamp(from.values.dissolve, 0.0f, 1.0f);
    }

    /// Index into images_; no_index, with a note, if there is no such image.
    std::uint32_t image_of(const MtlMaterial& from, const std::string& statement) {
        if (!from.gives(statement))
            return no_index;
        const std::string& written = from.textures.at(statement).name;
        const auto file = find_named_file(fs::path(from.file).parent_path(), written);
        if (!file) {
            notes_.add(from.where(statement), "no file \"" + written + "\": left out");
            return no_index;
        }
        return read(*file, from.where(statement));
    }

    static bool clamps(const MtlMaterial& from) {
        const auto colour = from.textures.find(from.gives("map_Kd") ? "map_Kd" : "map_Ka");
        return colour != from.textures.end() && colour->second.clamp;
    }

    /// A file is read once, however its name is written.
    std::uint32_t read(const fs::path& file, const std::string& where) {
        std::error_code error;
        const fs::path canonical = fs::canonical(file, error);
        const auto [entry, added] = image_of_file_.try_emplace(error ? file : canonical, no_index);
        if (!added)
            return entry->second;
        try {
            Image image{file, read_file_bytes(file, "texture", texture_size_limit), {}};
            EncodedImage(image.bytes, image.name(), file.string());
            entry->second = static_cast<std::uint32_t>(images_.size());
            images_.push_back(std::move(image));
        } catch (const InputError& problem) {
            notes_.add(where, std::string(problem.what()) + ": left out");
            return no_index;
        }
        require_at_most_4_gib(image_bytes_ += images_.back().bytes.size(), where, "images");
        return entry->second;
    }

    std::uint32_t use_texture(std::uint32_t index, const MtlMaterial& from) {
        const bool clamp = clamps(from);
        Image& image = images_[index];
        const auto [entry, added] = image.textures.try_emplace(clamp, static_cast<std::uint32_t>(out_.textures.size()));
        if (added) {
            Texture texture;
            texture.name = image.name();
            texture.encoded = image.bytes;
            require_at_most_4_gib(texture_bytes_ += image.bytes.size(), image.file.string(), "textures");
            texture.wrap_u = texture.wrap_v = clamp ? Wrap::clamp : Wrap::repeat;
            out_.textures.push_back(std::move(texture));
        }
        return entry->second;
    }

    /// From map_d, or else the alpha of the colour's own image where that cuts anything.
    std::uint32_t mask_of(const MtlMaterial& from, const std::string& colour_map, std::uint32_t colours) {
        const std::uint32_t own = image_of(from, "map_d");
        const bool grey = own != no_index;
        const std::uint32_t index = grey ? own : colours;
        if (index == no_index)
            return no_index;
        const bool clamp = clamps(from);
        const auto [entry, added] = mask_of_image_.try_emplace({index, grey, clamp}, no_index);
        if (!added)
            return entry->second;
        const Image& image = images_[index];
        try {
            AlphaMask mask = decode_alpha_mask(
                {.encoded = image.bytes, .name = image.name(), .where = image.file.string(), .grey_is_alpha = grey});
            const bool is_empty = std::ranges::all_of(mask.opaque, [](std::uint8_t texel) { return texel == 0; });
            if (!grey && is_empty) {  // the fourth byte of many images of 32 bits is nobody's
                notes_.add(from.where(colour_map), image.file.string() + " has an alpha of 0 everywhere: not used");
            } else if (mask.cuts()) {
                mask.wrap_u = mask.wrap_v = clamp ? Wrap::clamp : Wrap::repeat;
                entry->second = static_cast<std::uint32_t>(out_.alpha_masks.size());
                mask_bytes_ += mask.opaque.size();
                out_.alpha_masks.push_back(std::move(mask));
            }
        } catch (const InputError& error) {
            notes_.add(from.where(grey ? "map_d" : colour_map), std::string(error.what()) + ": nothing is cut away");
        }
        require_at_most_4_gib(mask_bytes_, image.file.string(), "masks");
        return entry->second;
    }

    struct Image {
        fs::path file;  ///< as it is written where it is named first
        std::vector<std::uint8_t> bytes;
        std::map<bool, std::uint32_t> textures;  ///< by whether they are clamped

        std::string name() const { return file.filename().string(); }
    };
    struct MaskKey {
        std::uint32_t image;
        bool grey, clamp;
        auto operator<=>(const MaskKey&) const = default;
    };

    const ModelOptions& options_;
    ObjNotes& notes_;
    ObjMaterials out_;
    std::vector<Image> images_;
    std::map<fs::path, std::uint32_t> image_of_file_;
    std::map<MaskKey, std::uint32_t> mask_of_image_;
    std::uint64_t image_bytes_ = 0, texture_bytes_ = 0, mask_bytes_ = 0;
};

}  // namespace

ObjMaterials convert_materials(const std::vector<MtlMaterial>& from, const std::vector<bool>& used,
                               const ModelOptions& options, ObjNotes& notes) {
    return Converter(options, notes).convert(from, used);
}

float roughness_of_exponent(float ns) {
    return std::sqrt(std::sqrt(2 / (std::max(ns, 0.0f) + 2)));
}

}  // namespace equistream
