#include "file_bytes.h"
#include "gltf_document.h"
#include "model.h"

#include <plugin/pictures/encoded_image.h>

#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <compare>
#include <map>

namespace equistream {

namespace {

Wrap wrap_of(int mode, const std::string& where) {
    switch (mode) {
    case TINYGLTF_TEXTURE_WRAP_REPEAT:
        return Wrap::repeat;
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
        return Wrap::clamp;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
        return Wrap::mirror;
    default:
        throw InputError(expected_found(where, "wrap mode 10497, 33071 or 33648", std::to_string(mode)));
    }
}

glm::vec3 colour_of(const std::vector<double>& values, const glm::vec3& otherwise) {
    if (values.size() < 3)
        return otherwise;
    return {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])};
}

/// Reflects 99.6 %.
constexpr double max_index = 1000;
/// Of radiance: the largest that a film's sums of floats still hold.
constexpr double max_emission = 1e12;

/// A number of a material extension, or the extension's default.
double extension_number(const tinygltf::Material& material, const char* extension, const char* key, double otherwise) {
    const auto found = material.extensions.find(extension);
    if (found == material.extensions.end() || !found->second.Has(key) || !found->second.Get(key).IsNumber())
        return otherwise;
    return found->second.Get(key).GetNumberAsDouble();
}

class MaterialReader {
public:
    MaterialReader(const GltfDocument& document, const ModelOptions& options)
        : document_(document), options_(options) {}

    GltfMaterials read() {
        const auto& all = document_.json().materials;
        for (std::size_t i = 0; i < all.size(); ++i)
            read_material(all[i], document_.where("material", i));
        out_.materials.emplace_back();
        out_.texture_coordinates.emplace_back();
        if (options_.shading)
            read_textures();
        decode_masks();
        return std::move(out_);
    }

private:
    struct MaskSource {
        int texture = -1;  ///< -1: the factor alone decides
        float alpha_factor = 1;
        float cutoff = 0.5f;
        auto operator<=>(const MaskSource&) const = default;
    };

    void read_material(const tinygltf::Material& from, const std::string& where) {
        Material to;
        to.name = from.name;
        TextureCoordinates coordinates;
        const tinygltf::PbrMetallicRoughness surface = surface_of(from);
        if (options_.shading) {
            to.base_colour = colour_of(surface.baseColorFactor, glm::vec3(1));
            to.base_colour_texture = use_texture(surface.baseColorTexture, where, coordinates);
            to.metallic = static_cast<float>(surface.metallicFactor);
            to.roughness = static_cast<float>(surface.roughnessFactor);
            to.metallic_roughness_texture = use_texture(surface.metallicRoughnessTexture, where, coordinates);
            to.emission =
                colour_of(from.emissiveFactor, glm::vec3(0)) *
                static_cast<float>(extension_number(from, "KHR_materials_emissive_strength", "emissiveStrength", 1));
            to.emission_texture = use_texture(from.emissiveTexture, where, coordinates);
            to.transmission = transmission_of(from);
            to.index_of_refraction = index_of_refraction(from, where);
            require_in_range(to, where);
        }
        to.double_sided = from.doubleSided;
        if (from.alphaMode == "MASK")
            to.alpha_mask = use_mask(from, where, coordinates);
        out_.materials.push_back(std::move(to));
        out_.texture_coordinates.push_back(coordinates);
    }

    /// Of an old material of specular colours its diffuse one, where it has no other.
    static tinygltf::PbrMetallicRoughness surface_of(const tinygltf::Material& from) {
        tinygltf::PbrMetallicRoughness surface = from.pbrMetallicRoughness;
        const auto found = from.extensions.find("KHR_materials_pbrSpecularGlossiness");
        if (found == from.extensions.end() || !found->second.IsObject() ||
            !(surface == tinygltf::PbrMetallicRoughness()))
            return surface;
        surface.metallicFactor = 0;
        surface.roughnessFactor = std::clamp(
            1 - extension_number(from, "KHR_materials_pbrSpecularGlossiness", "glossinessFactor", 1), 0.0, 1.0);
        if (const tinygltf::Value& texture = found->second.Get("diffuseTexture");
            texture.Has("index") && texture.Get("index").IsInt()) {
            surface.baseColorTexture.index = texture.Get("index").GetNumberAsInt();
            if (texture.Has("texCoord") && texture.Get("texCoord").IsInt())
                surface.baseColorTexture.texCoord = texture.Get("texCoord").GetNumberAsInt();
            constexpr const char* transform = "KHR_texture_transform";
            if (const tinygltf::Value& own = texture.Get("extensions"); own.IsObject() && own.Has(transform))
                surface.baseColorTexture.extensions[transform] = own.Get(transform);
        }
        if (const tinygltf::Value& colour = found->second.Get("diffuseFactor");
            colour.IsArray() && colour.ArrayLen() == 4)
            for (int i = 0; i < 4; ++i)
                surface.baseColorFactor[std::size_t(i)] =
                    colour.Get(i).IsNumber() ? colour.Get(i).GetNumberAsDouble() : 1;
        return surface;
    }

    /// Where a texture says how much, none: what is opaque must not become glass.
    static float transmission_of(const tinygltf::Material& from) {
        const auto found = from.extensions.find("KHR_materials_transmission");
        if (found != from.extensions.end() && found->second.Has("transmissionTexture"))
            return 0;
        return static_cast<float>(extension_number(from, "KHR_materials_transmission", "transmissionFactor", 0));
    }

    /// The extension writes 0 for infinity; Fresnel's equations want a number.
    static float index_of_refraction(const tinygltf::Material& from, const std::string& where) {
        const double index = extension_number(from, "KHR_materials_ior", "ior", 1.5);
        if (!(index == 0 || index >= 1))
            throw InputError(expected_found(where, "an ior of 0 or from 1", formatted("%g", index)));
        return static_cast<float>(index == 0 ? max_index : std::min(index, max_index));
    }

    /// glTF 2.0, 5.19 and 5.22: factors are 0 to 1; the strength of emission has no limit there.
    static void require_in_range(const Material& m, const std::string& where) {
        const auto require = [&](const char* name, float value, double most) {
            if (const auto problem = range_mismatch(value, 0, most))
                throw InputError(expected_found(where + ": " + name, problem->expected, problem->found));
        };
        for (int channel = 0; channel < 3; ++channel) {
            require("baseColorFactor", m.base_colour[channel], 1);
            require("emissiveFactor times emissiveStrength", m.emission[channel], max_emission);
        }
        require("metallicFactor", m.metallic, 1);
        require("roughnessFactor", m.roughness, 1);
        require("transmissionFactor", m.transmission, 1);
    }

    /// Checks a texture reference and returns its index; all textures of a material must share one set of coordinates.
    template <typename TextureInfo>
    std::uint32_t use_texture(const TextureInfo& info, const std::string& where,
                              TextureCoordinates& coordinates) const {
        if (info.index < 0)
            return no_index;
        const TextureCoordinates own = coordinates_of(info, where);
        if (coordinates.set >= 0 && coordinates.set != own.set)
            throw InputError(expected_found(where, "textures that share TEXCOORD_" + std::to_string(coordinates.set),
                                            "TEXCOORD_" + std::to_string(own.set)));
        if (coordinates.set >= 0 && coordinates != own)
            throw InputError(expected_found(where, "textures that share one KHR_texture_transform", "two"));
        coordinates = own;
        return static_cast<std::uint32_t>(
            document_.checked(info.index, document_.json().textures.size(), where, "a texture"));
    }

    template <typename TextureInfo>
    static TextureCoordinates coordinates_of(const TextureInfo& info, const std::string& where) {
        TextureCoordinates own;
        own.set = info.texCoord;
        const auto found = info.extensions.find("KHR_texture_transform");
        if (found == info.extensions.end())
            return own;
        const tinygltf::Value& transform = found->second;
        const auto number = [&](const tinygltf::Value& value, double& to) {
            if (!value.IsNumber() || !std::isfinite(static_cast<float>(value.GetNumberAsDouble())))
                throw InputError(expected_found(where + ", KHR_texture_transform", "finite numbers", "something else"));
            to = value.GetNumberAsDouble();
        };
        const auto pair = [&](const char* key, glm::dvec2& to) {
            if (!transform.Has(key))
                return;
            const tinygltf::Value& list = transform.Get(key);
            if (!list.IsArray() || list.ArrayLen() != 2)
                throw InputError(expected_found(where + ", KHR_texture_transform", std::string("two numbers as ") + key,
                                                "something else"));
            number(list.Get(0), to.x);
            number(list.Get(1), to.y);
        };
        pair("offset", own.offset);
        pair("scale", own.scale);
        if (transform.Has("rotation"))
            number(transform.Get("rotation"), own.rotation_rad);
        if (transform.Has("texCoord") && transform.Get("texCoord").IsInt())
            own.set = transform.Get("texCoord").GetNumberAsInt();
        return own;
    }

    std::uint32_t use_mask(const tinygltf::Material& from, const std::string& where, TextureCoordinates& coordinates) {
        MaskSource source;
        const tinygltf::PbrMetallicRoughness surface = surface_of(from);
        source.alpha_factor =
            surface.baseColorFactor.size() == 4 ? static_cast<float>(surface.baseColorFactor[3]) : 1.0f;
        source.cutoff = static_cast<float>(from.alphaCutoff);
        if (use_texture(surface.baseColorTexture, where, coordinates) != no_index)
            source.texture = surface.baseColorTexture.index;
        else if (source.alpha_factor >= source.cutoff)
            return no_index;
        const auto [entry, added] = mask_index_.try_emplace(source, static_cast<std::uint32_t>(mask_sources_.size()));
        if (added)
            mask_sources_.push_back(source);
        return entry->second;
    }

    void require_textures_memory() const {
        std::uint64_t bytes = 0;
        for (const tinygltf::Texture& texture : document_.json().textures)
            if (texture.source >= 0)
                bytes += document_.image(texture.source).size();
        require_at_most_4_gib(bytes, document_.file(), "textures");
    }

    void read_textures() {
        require_textures_memory();
        const auto& all = document_.json().textures;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const std::string where = document_.where("texture", i);
            if (all[i].source < 0)
                throw InputError(expected_found(where, "an image in PNG or JPEG",
                                                all[i].extensions.empty() ? "none" : all[i].extensions.begin()->first));
            const auto bytes = document_.image(all[i].source);
            const tinygltf::Image& image = document_.json().images[static_cast<std::size_t>(all[i].source)];
            Texture texture;
            texture.name = !image.name.empty() ? image.name : image.uri;
            texture.mime_type = image.mimeType;
            texture.encoded.assign(bytes.begin(), bytes.end());
            apply_sampler(all[i].sampler, where, texture);
            out_.textures.push_back(std::move(texture));
        }
    }

    template <typename Target>
    const tinygltf::Sampler* apply_wrap(int sampler, const std::string& where, Target& target) const {
        if (sampler < 0)
            return nullptr;
        const auto& samplers = document_.json().samplers;
        const tinygltf::Sampler& from = samplers[document_.checked(sampler, samplers.size(), where, "a sampler")];
        target.wrap_u = wrap_of(from.wrapS, where);
        target.wrap_v = wrap_of(from.wrapT, where);
        return &from;
    }

    void apply_sampler(int sampler, const std::string& where, Texture& texture) const {
        if (const tinygltf::Sampler* from = apply_wrap(sampler, where, texture))
            texture.nearest = from->magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }

    AlphaMask decode_mask(const MaskSource& source) const {
        if (source.texture < 0)
            return constant_alpha_mask(false);
        const auto index = static_cast<std::size_t>(source.texture);
        const tinygltf::Texture& texture = document_.json().textures[index];
        const std::string where = document_.where("texture", index);
        AlphaMask mask = decode_alpha_mask({.encoded = document_.image(texture.source),
                                            .name = {},
                                            .where = where,
                                            .alpha_factor = source.alpha_factor,
                                            .cutoff = source.cutoff});
        apply_wrap(texture.sampler, where, mask);
        return mask;
    }

    /// Each texture, factor and cutoff has a mask of its own.
    void require_masks_memory() const {
        std::map<int, std::uint64_t> pixels_of_image;
        std::uint64_t bytes = 0;
        for (const MaskSource& source : mask_sources_) {
            if (source.texture < 0)
                continue;
            const auto index = static_cast<std::size_t>(source.texture);
            const int image = document_.json().textures[index].source;
            const auto [entry, added] = pixels_of_image.try_emplace(image, 0);
            if (added) {
                const EncodedImage encoded(document_.image(image), {}, document_.where("texture", index));
                if (encoded.alpha_channel() >= 0)
                    entry->second =
                        static_cast<std::uint64_t>(encoded.width()) * static_cast<std::uint64_t>(encoded.height());
            }
            bytes += entry->second;
        }
        require_at_most_4_gib(bytes, document_.file(), "masks");
    }

    void decode_masks() {
        require_masks_memory();
        out_.alpha_masks.resize(mask_sources_.size());
        tbb::parallel_for(std::size_t{0}, mask_sources_.size(),
                          [this](std::size_t i) { out_.alpha_masks[i] = decode_mask(mask_sources_[i]); });
    }

    const GltfDocument& document_;
    const ModelOptions& options_;
    GltfMaterials out_;
    std::vector<MaskSource> mask_sources_;
    std::map<MaskSource, std::uint32_t> mask_index_;
};

}  // namespace

glm::vec2 TextureCoordinates::moved(const glm::vec2& uv) const {
    const glm::dvec2 scaled = scale * glm::dvec2(uv);
    const double c = std::cos(rotation_rad), s = std::sin(rotation_rad);
    return {static_cast<float>(offset.x + c * scaled.x + s * scaled.y),
            static_cast<float>(offset.y - s * scaled.x + c * scaled.y)};
}

GltfMaterials read_materials(const GltfDocument& document, const ModelOptions& options) {
    return MaterialReader(document, options).read();
}

}  // namespace equistream
