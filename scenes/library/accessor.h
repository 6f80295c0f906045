#pragma once
/// Typed reading of glTF accessors from checked bytes: every component type, strides, normalised integers
/// (KHR_mesh_quantization) and sparse overlays. Knows nothing of the parser that found the bytes.
#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream {

enum class ComponentType { i8 = 5120, u8, i16, u16, u32 = 5125, f32 };  ///< glTF's own numbers

std::size_t component_size(ComponentType type);

struct SparseAccessor {
    std::size_t count = 0;
    ComponentType index_type = ComponentType::u32;
    std::span<const std::uint8_t> indices;
    std::span<const std::uint8_t> values;
};

/// `bytes` starts at the first element and ends with the buffer view; without any, elements are zero (sparse bases).
struct Accessor {
    std::string where;  ///< "FILE: accessor 12", for errors
    std::span<const std::uint8_t> bytes;
    bool has_bytes = true;
    std::size_t count = 0;
    std::size_t stride = 0;
    ComponentType type = ComponentType::f32;
    int components = 1;
    bool normalised = false;
    std::optional<SparseAccessor> sparse;
};

/// An accessor without bytes is all zeros: only its claim says how long it is, so claims are capped, of one accessor
/// and of all uses of a model's together.
constexpr std::size_t zero_element_limit = std::size_t{1} << 20;

/// These throw InputError naming `where` if the bytes do not hold what the accessor claims, or a value is not finite.
/// Vectors are allocated with room for one more element, so that Embree may read 16 bytes at the last one.
std::vector<glm::vec2> read_vec2(const Accessor& accessor);
std::vector<glm::vec3> read_vec3(const Accessor& accessor);
std::vector<std::uint32_t> read_indices(const Accessor& accessor);

}  // namespace equistream
