#include "gltf_document.h"

#include "file_bytes.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <set>
#include <utility>

namespace equistream {

namespace fs = std::filesystem;

namespace {

/// GLB lengths are 32 bits; nothing larger can be a valid one.
constexpr std::uint64_t file_size_limit = 0xffffffffull;
/// tinygltf converts `extras` recursively, so nesting is bounded before it sees the text.
constexpr int nesting_limit = 128;

const std::set<std::string>& accepted_extensions() {
    static const std::set<std::string> names{"KHR_mesh_quantization", "KHR_materials_transmission", "KHR_materials_ior",
                                             "KHR_materials_emissive_strength", "KHR_texture_transform"};
    return names;
}

/// Called by tinygltf for each image; keeps the bytes of those that do not lie in a buffer view, decodes none.
bool keep_encoded(tinygltf::Image* image, const int index, std::string*, std::string*, int, int,
                  const unsigned char* bytes, int size, void* user) {
    if (image->bufferView >= 0 || size <= 0)
        return true;
    auto& images = *static_cast<std::vector<std::vector<std::uint8_t>>*>(user);
    images.resize(std::max(images.size(), static_cast<std::size_t>(index) + 1));
    images[static_cast<std::size_t>(index)].assign(bytes, bytes + size);
    return true;
}

/// tinygltf also looks in the working directory; files are only taken from beside the model.
bool file_exists(const std::string& name, void*) {
    std::error_code error;
    return fs::path(name).is_absolute() && fs::is_regular_file(name, error);
}

/// The default expands shell syntax in file names, which no scene file should be able to do.
std::string keep_path(const std::string& name, void*) {
    return name;
}

/// What was read of buffers and images beside the model. tinygltf reads a file each time that it is named.
struct FilesBeside {
    std::string model;
    std::uint64_t bytes = 0;
};

bool read_whole(std::vector<unsigned char>* out, std::string* error, const std::string& name, void* user) {
    try {
        *out = read_file_bytes(name, "file of the model", file_size_limit);
    } catch (const InputError& e) {
        *error = e.what();
        return false;
    }
    auto& files = *static_cast<FilesBeside*>(user);
    require_at_most_4_gib(files.bytes += out->size(), files.model, "files beside it");
    return true;
}

std::string one_line(std::string text) {
    while (!text.empty() && text.back() == '\n')
        text.pop_back();
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text.substr(0, 300);
}

bool is_glb(std::span<const std::uint8_t> bytes) {
    return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
}

std::uint32_t little_endian_u32(const std::uint8_t* b) {
    return static_cast<std::uint32_t>(b[0]) | static_cast<std::uint32_t>(b[1]) << 8 |
           static_cast<std::uint32_t>(b[2]) << 16 | static_cast<std::uint32_t>(b[3]) << 24;
}

/// tinygltf finds no triangles in earlier versions, and says nothing.
void require_version_2(const std::string& file, const std::string& version) {
    if (version != "2" && !version.starts_with("2."))
        throw InputError(expected_found(file, "a glTF 2.0 model", "version " + version));
}

/// tinygltf says only "invalid"; a cut download deserves better.
void check_glb_header(const std::string& file, std::span<const std::uint8_t> bytes) {
    constexpr std::size_t header = 20;
    if (bytes.size() < header)
        throw InputError(expected_found(file, "a GLB header of 20 bytes", std::to_string(bytes.size()) + " bytes"));
    require_version_2(file, std::to_string(little_endian_u32(bytes.data() + 4)));
    const std::uint32_t length = little_endian_u32(bytes.data() + 8);
    if (length > bytes.size())
        throw InputError(expected_found(file, std::to_string(length) + " bytes as its header says",
                                        std::to_string(bytes.size()) + " (truncated)"));
}

void check_nesting(const std::string& file, std::span<const std::uint8_t> text) {
    int depth = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = static_cast<char>(text[i]);
        if (quoted) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                quoted = false;
        } else if (c == '"') {
            quoted = true;
        } else if (c == '{' || c == '[') {
            if (++depth > nesting_limit)
                throw InputError(expected_found(file, "JSON nested at most " + std::to_string(nesting_limit) + " deep",
                                                "deeper nesting"));
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
}

std::span<const std::uint8_t> json_text(std::span<const std::uint8_t> bytes) {
    if (!is_glb(bytes))
        return bytes;
    const std::size_t length = little_endian_u32(bytes.data() + 12);
    return bytes.subspan(20, std::min(length, bytes.size() - 20));
}

ComponentType component_type(int type, const std::string& where) {
    if (type < 5120 || type > 5126 || type == 5124)
        throw InputError(expected_found(where, "component type 5120 to 5123, 5125 or 5126", std::to_string(type)));
    return static_cast<ComponentType>(type);
}

std::span<const std::uint8_t> from_offset(std::span<const std::uint8_t> bytes, std::size_t offset,
                                          const std::string& where) {
    if (offset > bytes.size())
        throw InputError(expected_found(where, "an offset of at most " + std::to_string(bytes.size()) + " bytes",
                                        std::to_string(offset)));
    return bytes.subspan(offset);
}

}  // namespace

GltfDocument::GltfDocument(const fs::path& file) : file_(file.string()) {
    std::vector<std::uint8_t> bytes = read_file_bytes(file, "glTF model", file_size_limit);
    if (is_glb(bytes))
        check_glb_header(file_, bytes);
    check_nesting(file_, json_text(bytes));

    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_encoded, &external_images_);
    FilesBeside files{file_};
    loader.SetFsCallbacks({file_exists, keep_path, read_whole, nullptr, &files});
    const std::string folder = fs::absolute(file).parent_path().string();
    std::string error;
    std::string warning;
    bool loaded = false;
    try {
        const auto size = static_cast<unsigned>(bytes.size());
        loaded = is_glb(bytes) ? loader.LoadBinaryFromMemory(&model_, &error, &warning, bytes.data(), size, folder)
                               : loader.LoadASCIIFromString(&model_, &error, &warning,
                                                            reinterpret_cast<const char*>(bytes.data()), size, folder);
    } catch (const InputError&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;  // not the file's fault
    } catch (const std::exception& e) {
        error = e.what();
    }
    if (!loaded)
        throw InputError(
            expected_found(file_, "a glTF 2.0 model", one_line(error.empty() ? "unreadable data" : error)));
    if (!model_.asset.version.empty())
        require_version_2(file_, model_.asset.version);
    std::string accepted;
    for (const std::string& name : accepted_extensions())
        accepted += (accepted.empty() ? " " : ", ") + name;
    for (const std::string& name : model_.extensionsRequired)
        if (!accepted_extensions().contains(name))
            throw InputError(expected_found(file_, "only the required extensions" + accepted, name));
}

std::string GltfDocument::where(const char* what, std::size_t index) const {
    return file_ + ": " + what + " " + std::to_string(index);
}

std::size_t GltfDocument::checked(int index, std::size_t size, const std::string& where, const char* what) const {
    if (index < 0 || static_cast<std::size_t>(index) >= size)
        throw InputError(
            expected_found(where, std::string(what) + " below " + std::to_string(size), std::to_string(index)));
    return static_cast<std::size_t>(index);
}

std::span<const std::uint8_t> GltfDocument::buffer_view(int index, const std::string& where) const {
    const auto& view = model_.bufferViews[checked(index, model_.bufferViews.size(), where, "a buffer view")];
    const auto& data = model_.buffers[checked(view.buffer, model_.buffers.size(), where, "a buffer")].data;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
        throw InputError(expected_found(where + ", buffer view " + std::to_string(index),
                                        "bytes within a buffer of " + std::to_string(data.size()),
                                        std::to_string(view.byteLength) + " at " + std::to_string(view.byteOffset)));
    return std::span(data).subspan(view.byteOffset, view.byteLength);
}

Accessor GltfDocument::accessor(int index) const {
    const auto& from = model_.accessors[checked(index, model_.accessors.size(), file_, "an accessor")];
    Accessor to;
    to.where = where("accessor", static_cast<std::size_t>(index));
    to.count = from.count;
    to.type = component_type(from.componentType, to.where);
    to.components = std::max(0, tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(from.type)));
    to.normalised = from.normalized;
    to.stride = component_size(to.type) * static_cast<std::size_t>(to.components);
    to.has_bytes = from.bufferView >= 0;
    if (to.has_bytes) {
        to.bytes = from_offset(buffer_view(from.bufferView, to.where), from.byteOffset, to.where);
        const std::size_t stride = model_.bufferViews[static_cast<std::size_t>(from.bufferView)].byteStride;
        to.stride = stride > 0 ? stride : to.stride;
    }
    if (from.sparse.isSparse) {
        const auto& indices = from.sparse.indices;
        const auto& values = from.sparse.values;
        SparseAccessor sparse;
        sparse.count = static_cast<std::size_t>(std::max(0, from.sparse.count));
        sparse.index_type = component_type(indices.componentType, to.where);
        sparse.indices = from_offset(buffer_view(indices.bufferView, to.where),
                                     static_cast<std::size_t>(indices.byteOffset), to.where);
        sparse.values = from_offset(buffer_view(values.bufferView, to.where),
                                    static_cast<std::size_t>(values.byteOffset), to.where);
        to.sparse = sparse;
    }
    return to;
}

std::span<const std::uint8_t> GltfDocument::image(int index) const {
    const std::size_t i = checked(index, model_.images.size(), file_, "an image");
    const tinygltf::Image& image = model_.images[i];
    if (image.bufferView >= 0)
        return buffer_view(image.bufferView, where("image", i));
    if (i >= external_images_.size() || external_images_[i].empty())
        throw InputError(expected_found(where("image", i), "a readable image file beside the model",
                                        image.uri.empty() ? "no image data" : "none at " + image.uri));
    return external_images_[i];
}

namespace {

/// Extensions of materials that are not read, as people call them.
constexpr std::array<std::pair<const char*, const char*>, 10> material_extensions = {
    {{"KHR_materials_volume", "volume"},
     {"KHR_materials_clearcoat", "clear coat"},
     {"KHR_materials_sheen", "sheen"},
     {"KHR_materials_specular", "specular factors"},
     {"KHR_materials_anisotropy", "anisotropy"},
     {"KHR_materials_iridescence", "iridescence"},
     {"KHR_materials_dispersion", "dispersion"},
     {"KHR_materials_diffuse_transmission", "diffuse transmission"},
     {"KHR_materials_unlit", "colours that no light changes"},
     {"KHR_materials_pbrSpecularGlossiness", "specular colours"}}};
constexpr const char *lights_extension = "KHR_lights_punctual", *copies_extension = "EXT_mesh_gpu_instancing";

using LeftOut = std::vector<std::string>;

void add(LeftOut& left_out, const std::string& what, std::ptrdiff_t count, const std::string& one) {
    if (count > 0)
        left_out.push_back(what + " (" + std::to_string(count) + " " + one + (count == 1 ? ")" : "s)"));
}

template <typename Is>
std::ptrdiff_t count_primitives(const tinygltf::Model& model, const Is& is) {
    std::ptrdiff_t count = 0;
    for (const tinygltf::Mesh& mesh : model.meshes)
        count += std::ranges::count_if(mesh.primitives, is);
    return count;
}

void add_shading(const tinygltf::Model& model, LeftOut& left_out) {
    const auto of_materials = [&](const std::string& what, const auto& is) {
        add(left_out, what, std::ranges::count_if(model.materials, is), "material");
    };
    using Material = tinygltf::Material;
    of_materials("normal maps", [](const Material& m) { return m.normalTexture.index >= 0; });
    of_materials("blending, taken as opaque", [](const Material& m) { return m.alphaMode == "BLEND"; });
    for (const auto& known : material_extensions)
        of_materials(known.second, [&](const Material& m) { return m.extensions.contains(known.first); });
    of_materials("textures of transmission, taken as opaque", [](const Material& m) {
        const auto found = m.extensions.find("KHR_materials_transmission");
        return found != m.extensions.end() && found->second.Has("transmissionTexture");
    });
    add(left_out, "vertex colours",
        count_primitives(model, [](const auto& p) { return p.attributes.contains("COLOR_0"); }), "primitive");
    if (std::ranges::find(model.extensionsUsed, lights_extension) != model.extensionsUsed.end())
        left_out.push_back("lights");
}

/// Of which nothing else is said.
void add_unknown(const tinygltf::Model& model, LeftOut& left_out) {
    std::vector<std::string> unknown;
    for (const std::string& name : std::set<std::string>(model.extensionsUsed.begin(), model.extensionsUsed.end()))
        if (!accepted_extensions().contains(name) && name != lights_extension && name != copies_extension &&
            std::ranges::find(material_extensions, name, [](const auto& known) { return std::string(known.first); }) ==
                material_extensions.end())
            unknown.push_back(quotable(name, 60));
    constexpr std::size_t max_named = 5;
    const std::size_t others = unknown.size() - std::min(unknown.size(), max_named);
    unknown.resize(unknown.size() - others);
    if (others > 0)
        unknown.push_back(std::to_string(others) + " more");
    for (const std::string& name : unknown)
        left_out.push_back(name);
}

}  // namespace

std::string left_out_note(const GltfDocument& document, const ModelOptions& options) {
    const tinygltf::Model& model = document.json();
    LeftOut left_out;
    if (options.shading)
        add_shading(model, left_out);
    add(left_out, "skins", std::ssize(model.skins), "skin");
    add(left_out, "morph targets", count_primitives(model, [](const auto& p) { return !p.targets.empty(); }),
        "primitive");
    add(left_out, "points and lines",
        count_primitives(model, [](const auto& p) { return p.mode >= 0 && p.mode < TINYGLTF_MODE_TRIANGLES; }),
        "primitive");
    add(left_out, "animations", std::ssize(model.animations), "animation");
    add(left_out, "copies",
        std::ranges::count_if(model.nodes,
                              [](const tinygltf::Node& node) { return node.extensions.contains(copies_extension); }),
        "node");
    add_unknown(model, left_out);
    return left_out.empty() ? "" : document.file() + ": left out: " + in_a_sentence(left_out, " and ");
}

}  // namespace equistream
