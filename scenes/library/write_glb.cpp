#include "write_glb.h"

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/sequence.h>

#include <glm/gtc/type_ptr.hpp>
#include <tiny_gltf.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>

namespace equistream {
namespace {

static_assert(sizeof(glm::vec3) == 12 && sizeof(glm::vec2) == 8 && sizeof(glm::uvec3) == 12);

/// Appends everything to the one embedded buffer.
class GlbBuilder {
public:
    explicit GlbBuilder(const SceneModel& model) : model_(model) {
        out_.asset.version = "2.0";
        out_.asset.generator = "equistream";
        out_.defaultScene = 0;
        out_.scenes.resize(1);
        for (const Texture& texture : model.textures)
            add_texture(texture);
        for (const Material& material : model.materials)
            add_material(material);
        for (const Mesh& mesh : model.meshes)
            primitives_.push_back(add_primitive(mesh));
        add_nodes();
        if (!bytes_.empty()) {
            out_.buffers.resize(1);
            out_.buffers[0].data = std::move(bytes_);
        }
    }

    const tinygltf::Model& result() const { return out_; }

private:
    int add_view(const void* data, std::size_t size, int target) {
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
        tinygltf::BufferView view;
        view.buffer = 0;
        view.byteOffset = bytes_.size();
        view.byteLength = size;
        view.target = target;
        const auto* first = static_cast<const unsigned char*>(data);
        bytes_.insert(bytes_.end(), first, first + size);
        out_.bufferViews.push_back(view);
        return static_cast<int>(out_.bufferViews.size()) - 1;
    }

    int add_accessor(int view, int component, int type, std::size_t count) {
        tinygltf::Accessor accessor;
        accessor.bufferView = view;
        accessor.componentType = component;
        accessor.type = type;
        accessor.count = count;
        out_.accessors.push_back(accessor);
        return static_cast<int>(out_.accessors.size()) - 1;
    }

    template <typename V>
    int add_attribute(const std::vector<V>& values) {
        const int view = add_view(values.data(), values.size() * sizeof(V), TINYGLTF_TARGET_ARRAY_BUFFER);
        return add_accessor(view, TINYGLTF_COMPONENT_TYPE_FLOAT,
                            sizeof(V) == 12 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_VEC2, values.size());
    }

    int add_indices(const Mesh& mesh) {
        const std::size_t count = mesh.triangles.size() * 3;
        const unsigned* first = glm::value_ptr(mesh.triangles.front());
        if (mesh.positions.size() > std::numeric_limits<std::uint16_t>::max())
            return add_accessor(add_view(first, count * 4, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER),
                                TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, count);
        std::vector<std::uint16_t> narrow(count);
        std::transform(first, first + count, narrow.begin(), [](unsigned i) { return static_cast<std::uint16_t>(i); });
        return add_accessor(add_view(narrow.data(), count * 2, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER),
                            TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_SCALAR, count);
    }

    tinygltf::Primitive add_primitive(const Mesh& mesh) {
        assert(!mesh.positions.empty() && !mesh.triangles.empty());
        tinygltf::Primitive primitive;
        primitive.mode = TINYGLTF_MODE_TRIANGLES;
        const int positions = add_attribute(mesh.positions);
        glm::vec3 low = mesh.positions.front(), high = low;
        for (const glm::vec3& p : mesh.positions) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        out_.accessors[positions].minValues = {low.x, low.y, low.z};
        out_.accessors[positions].maxValues = {high.x, high.y, high.z};
        primitive.attributes["POSITION"] = positions;
        if (!mesh.normals.empty())
            primitive.attributes["NORMAL"] = add_attribute(mesh.normals);
        if (!mesh.uvs.empty())
            primitive.attributes["TEXCOORD_0"] = add_attribute(mesh.uvs);
        primitive.indices = add_indices(mesh);
        if (mesh.material != no_index)
            primitive.material = static_cast<int>(mesh.material);
        return primitive;
    }

    static int wrap_mode(Wrap wrap) {
        return wrap == Wrap::clamp    ? TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE
               : wrap == Wrap::mirror ? TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT
                                      : TINYGLTF_TEXTURE_WRAP_REPEAT;
    }

    void add_texture(const Texture& texture) {
        tinygltf::Image image;
        image.name = as_json_holds(texture.name);
        image.mimeType = texture.mime_type;
        image.bufferView = add_view(texture.encoded.data(), texture.encoded.size(), 0);
        out_.images.push_back(image);
        tinygltf::Sampler sampler;
        sampler.wrapS = wrap_mode(texture.wrap_u);
        sampler.wrapT = wrap_mode(texture.wrap_v);
        sampler.magFilter = texture.nearest ? TINYGLTF_TEXTURE_FILTER_NEAREST : TINYGLTF_TEXTURE_FILTER_LINEAR;
        sampler.minFilter =
            texture.nearest ? TINYGLTF_TEXTURE_FILTER_NEAREST : TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
        out_.samplers.push_back(sampler);
        tinygltf::Texture entry;
        entry.source = static_cast<int>(out_.images.size()) - 1;
        entry.sampler = static_cast<int>(out_.samplers.size()) - 1;
        out_.textures.push_back(entry);
    }

    void extend(tinygltf::Material& material, const std::string& extension, const std::string& key, double value) {
        material.extensions[extension] = tinygltf::Value(tinygltf::Value::Object{{key, tinygltf::Value(value)}});
        if (std::find(out_.extensionsUsed.begin(), out_.extensionsUsed.end(), extension) == out_.extensionsUsed.end())
            out_.extensionsUsed.push_back(extension);
    }

    void add_material(const Material& in) {
        tinygltf::Material out;
        out.name = as_json_holds(in.name);
        out.doubleSided = in.double_sided;
        auto& surface = out.pbrMetallicRoughness;
        surface.baseColorFactor = {in.base_colour.r, in.base_colour.g, in.base_colour.b, 1.0};
        surface.metallicFactor = in.metallic;
        surface.roughnessFactor = in.roughness;
        if (in.base_colour_texture != no_index)
            surface.baseColorTexture.index = static_cast<int>(in.base_colour_texture);
        if (in.metallic_roughness_texture != no_index)
            surface.metallicRoughnessTexture.index = static_cast<int>(in.metallic_roughness_texture);
        if (in.emission_texture != no_index)
            out.emissiveTexture.index = static_cast<int>(in.emission_texture);
        if (in.alpha_mask != no_index) {
            assert(in.base_colour_texture != no_index);
            out.alphaMode = "MASK";
        }
        // emissiveFactor may not exceed 1; the rest is strength.
        const float strength = std::max({1.0f, in.emission.r, in.emission.g, in.emission.b});
        const glm::vec3 factor = in.emission / strength;
        out.emissiveFactor = {factor.r, factor.g, factor.b};
        if (strength > 1)
            extend(out, "KHR_materials_emissive_strength", "emissiveStrength", strength);
        if (in.transmission > 0)
            extend(out, "KHR_materials_transmission", "transmissionFactor", in.transmission);
        if (in.index_of_refraction != 1.5f)
            extend(out, "KHR_materials_ior", "ior", in.index_of_refraction);
        out_.materials.push_back(out);
    }

    int shared_mesh(const std::vector<std::uint32_t>& meshes) {
        const auto [entry, is_new] = shared_.try_emplace(meshes, static_cast<int>(out_.meshes.size()));
        if (is_new) {
            tinygltf::Mesh mesh;
            mesh.name = as_json_holds(model_.meshes[meshes.front()].name);
            for (const std::uint32_t index : meshes)
                mesh.primitives.push_back(primitives_[index]);
            out_.meshes.push_back(mesh);
        }
        return entry->second;
    }

    void add_nodes() {
        const std::size_t count = model_.objects.size();
        std::vector<std::vector<std::uint32_t>> meshes(count);
        std::vector<glm::mat4> world;
        for (const Object& object : model_.objects)
            world.push_back(object.world_from_object);
        for (const Instance& instance : model_.instances) {
            assert(meshes[instance.object].empty() || world[instance.object] == instance.world_from_object);
            meshes[instance.object].push_back(instance.mesh);
            world[instance.object] = instance.world_from_object;
        }
        out_.nodes.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            const Object& object = model_.objects[i];
            out_.nodes[i].name = as_json_holds(object.name);
            if (!meshes[i].empty())
                out_.nodes[i].mesh = shared_mesh(meshes[i]);
            if (object.parent < 0)
                out_.scenes[0].nodes.push_back(static_cast<int>(i));
            else
                out_.nodes[object.parent].children.push_back(static_cast<int>(i));
            const glm::mat4 local = object.parent < 0 ? world[i] : glm::inverse(world[object.parent]) * world[i];
            if (local != glm::mat4(1))
                out_.nodes[i].matrix.assign(glm::value_ptr(local), glm::value_ptr(local) + 16);
        }
    }

    const SceneModel& model_;
    tinygltf::Model out_;
    std::vector<unsigned char> bytes_;
    std::vector<tinygltf::Primitive> primitives_;
    std::map<std::vector<std::uint32_t>, int> shared_;
};

}  // namespace

std::string glb_bytes(const SceneModel& model) {
    const GlbBuilder builder(model);
    std::ostringstream stream(std::ios::binary);
    tinygltf::TinyGLTF writer;
    if (!writer.WriteGltfSceneToStream(&builder.result(), stream, false, true) || !stream)
        throw WorkError("a glTF model could not be serialised");
    std::string bytes = std::move(stream).str();
    require_glb_size(bytes.size());
    return bytes;
}

void require_glb_size(std::uint64_t bytes) {
    if (bytes > std::numeric_limits<std::uint32_t>::max())
        throw WorkError("a model of " + std::to_string(bytes) +
                        " bytes does not fit into a GLB file, which ends at 4 GiB");
}

void write_glb(const std::filesystem::path& file, const SceneModel& model) {
    write_file_atomically(file, glb_bytes(model));
}

}  // namespace equistream
