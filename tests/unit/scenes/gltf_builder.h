#pragma once
/// Builds small glTF files byte by byte, so that tests can get every encoding, and every mistake, into one.
#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace equistream::test {

using Json = nlohmann::json;

constexpr int gl_byte = 5120, gl_unsigned_byte = 5121, gl_short = 5122, gl_unsigned_short = 5123,
              gl_unsigned_int = 5125, gl_float = 5126;

struct GltfBuilder {
    Json json = {{"asset", {{"version", "2.0"}}}};
    std::string buffer;

    /// Appends bytes, 4-aligned, and returns the index of a view on them.
    int view(const std::string& bytes, int stride = 0) {
        buffer.resize((buffer.size() + 3) / 4 * 4);
        Json view = {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}};
        if (stride > 0)
            view["byteStride"] = stride;
        json["bufferViews"].push_back(view);
        buffer += bytes;
        return static_cast<int>(json["bufferViews"].size()) - 1;
    }

    template <typename T>
    int accessor(const std::vector<T>& values, int component_type, const char* type, std::size_t count,
                 int stride = 0) {
        return accessor_of(view(bytes_of(values), stride), component_type, type, count);
    }

    int accessor_of(int view_index, int component_type, const char* type, std::size_t count) {
        json["accessors"].push_back(
            {{"bufferView", view_index}, {"componentType", component_type}, {"type", type}, {"count", count}});
        return static_cast<int>(json["accessors"].size()) - 1;
    }

    /// A mesh of one primitive; returns its index.
    int mesh(const Json& attributes, int indices = -1, int material = -1, int mode = 4) {
        Json primitive = {{"attributes", attributes}, {"mode", mode}};
        if (indices >= 0)
            primitive["indices"] = indices;
        if (material >= 0)
            primitive["material"] = material;
        json["meshes"].push_back({{"primitives", {primitive}}});
        return static_cast<int>(json["meshes"].size()) - 1;
    }

    int node(const Json& node) {
        json["nodes"].push_back(node);
        return static_cast<int>(json["nodes"].size()) - 1;
    }

    /// One triangle with corners 0, X, Y under a node: the least that loads.
    static GltfBuilder triangle() {
        GltfBuilder builder;
        const int positions = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, gl_float, "VEC3", 3);
        const int indices = builder.accessor<std::uint16_t>({0, 1, 2}, gl_unsigned_short, "SCALAR", 3);
        builder.node({{"name", "one"}, {"mesh", builder.mesh({{"POSITION", positions}}, indices)}});
        return builder;
    }

    std::string glb() const {
        Json all = json;
        all["buffers"] = {{{"byteLength", buffer.size()}}};
        std::string text = all.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::string data = buffer;
        data.resize((data.size() + 3) / 4 * 4, '\0');
        const auto total = static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + data.size());
        return "glTF" + u32(2) + u32(total) + u32(static_cast<std::uint32_t>(text.size())) + "JSON" + text +
               u32(static_cast<std::uint32_t>(data.size())) + std::string("BIN\0", 4) + data;
    }

    /// JSON text whose only buffer is found at `uri`.
    std::string gltf(const std::string& uri) const {
        Json all = json;
        all["buffers"] = {{{"byteLength", buffer.size()}, {"uri", uri}}};
        return all.dump();
    }

    template <typename T>
    static std::string bytes_of(const std::vector<T>& values) {
        std::string bytes(values.size() * sizeof(T), '\0');
        std::memcpy(bytes.data(), values.data(), bytes.size());
        return bytes;
    }

private:
    static std::string u32(std::uint32_t value) {
        std::string bytes(4, '\0');
        std::memcpy(bytes.data(), &value, 4);
        return bytes;
    }
};

}  // namespace equistream::test
