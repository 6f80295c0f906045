#include "gltf_document.h"

#include <equistream/comma_list.h>

#include <algorithm>
#include <array>
#include <utility>

namespace equistream {

namespace {

/// Extensions of materials that are not read, as people call them.
constexpr std::array<std::pair<const char*, const char*>, 8> material_extensions = {
    {{"KHR_materials_volume", "volume"},
     {"KHR_materials_clearcoat", "clear coat"},
     {"KHR_materials_sheen", "sheen"},
     {"KHR_materials_specular", "specular factors"},
     {"KHR_materials_anisotropy", "anisotropy"},
     {"KHR_materials_iridescence", "iridescence"},
     {"KHR_materials_dispersion", "dispersion"},
     {"KHR_materials_diffuse_transmission", "diffuse transmission"}}};

class LeftOut {
public:
    void add(const std::string& what, std::ptrdiff_t count, const char* one, const char* several) {
        if (count > 0)
            list_.push_back(what + " (" + std::to_string(count) + " " + (count == 1 ? one : several) + ")");
    }
    void add(const std::string& what, bool there) {
        if (there)
            list_.push_back(what);
    }
    const std::vector<std::string>& list() const { return list_; }

private:
    std::vector<std::string> list_;
};

template <typename Is>
std::ptrdiff_t count_primitives(const tinygltf::Model& model, const Is& is) {
    std::ptrdiff_t count = 0;
    for (const tinygltf::Mesh& mesh : model.meshes)
        count += std::ranges::count_if(mesh.primitives, is);
    return count;
}

void add_shading(const tinygltf::Model& model, LeftOut& left_out) {
    const auto of_materials = [&](const std::string& what, const auto& is) {
        left_out.add(what, std::ranges::count_if(model.materials, is), "material", "materials");
    };
    using Material = tinygltf::Material;
    of_materials("normal maps", [](const Material& m) { return m.normalTexture.index >= 0; });
    of_materials("blending, taken as opaque", [](const Material& m) { return m.alphaMode == "BLEND"; });
    for (const auto& [extension, name] : material_extensions)
        of_materials(name, [&](const Material& m) { return m.extensions.contains(extension); });
    left_out.add("vertex colours",
                 count_primitives(model, [](const auto& p) { return p.attributes.contains("COLOR_0"); }), "primitive",
                 "primitives");
    left_out.add("lights",
                 model.extensionsUsed.end() != std::ranges::find(model.extensionsUsed, "KHR_lights_punctual"));
}

}  // namespace

std::string left_out_note(const GltfDocument& document, const ModelOptions& options) {
    const tinygltf::Model& model = document.json();
    LeftOut left_out;
    if (options.shading)
        add_shading(model, left_out);
    left_out.add("skins", std::ssize(model.skins), "skin", "skins");
    left_out.add("morph targets", count_primitives(model, [](const auto& p) { return !p.targets.empty(); }),
                 "primitive", "primitives");
    left_out.add("points and lines",
                 count_primitives(model, [](const auto& p) { return p.mode >= 0 && p.mode < TINYGLTF_MODE_TRIANGLES; }),
                 "primitive", "primitives");
    left_out.add("animations", std::ssize(model.animations), "animation", "animations");
    return left_out.list().empty() ? "" : document.file() + ": left out: " + in_a_sentence(left_out.list(), " and ");
}

}  // namespace equistream
