#include "accessor.h"

#include <equistream/error.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace equistream {

namespace {

template <typename T>
T load(const std::uint8_t* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

/// glTF 2.0, section 3.11: signed integers are clamped at -1.
template <typename T>
float to_float(T value, bool normalised) {
    if constexpr (std::is_floating_point_v<T>)
        return value;
    else if (!normalised)
        return static_cast<float>(value);
    else
        return std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
}

template <typename Function>
auto with_component_type(ComponentType type, Function&& function) {
    switch (type) {
    case ComponentType::i8:
        return function(std::int8_t{});
    case ComponentType::u8:
        return function(std::uint8_t{});
    case ComponentType::i16:
        return function(std::int16_t{});
    case ComponentType::u16:
        return function(std::uint16_t{});
    case ComponentType::u32:
        return function(std::uint32_t{});
    case ComponentType::f32:
        break;
    }
    return function(float{});
}

void require_bytes(const std::string& where, std::size_t count, std::size_t stride, std::size_t element,
                   std::size_t available) {
    const bool fits = count == 0 || (element <= available && (count - 1) <= (available - element) / stride);
    if (!fits)
        throw InputError(expected_found(where,
                                        std::to_string(count) + " elements of " + std::to_string(element) +
                                            " bytes, stride " + std::to_string(stride),
                                        std::to_string(available) + " bytes"));
}

void check(const Accessor& accessor, int components) {
    if (accessor.components != components)
        throw InputError(expected_found(accessor.where, std::to_string(components) + " components",
                                        std::to_string(accessor.components)));
    const std::size_t element = component_size(accessor.type) * static_cast<std::size_t>(components);
    if (accessor.stride < element)
        throw InputError(expected_found(accessor.where, "a stride of at least " + std::to_string(element) + " bytes",
                                        std::to_string(accessor.stride)));
    if (accessor.has_bytes)
        require_bytes(accessor.where, accessor.count, accessor.stride, element, accessor.bytes.size());
    else if (accessor.count > zero_element_limit)
        throw InputError(expected_found(
            accessor.where, "at most " + std::to_string(zero_element_limit) + " elements without a buffer view",
            std::to_string(accessor.count)));
    if (!accessor.sparse)
        return;
    const SparseAccessor& sparse = *accessor.sparse;
    if (sparse.count > accessor.count)
        throw InputError(expected_found(accessor.where,
                                        "at most " + std::to_string(accessor.count) + " sparse elements",
                                        std::to_string(sparse.count)));
    const std::size_t index_size = component_size(sparse.index_type);
    require_bytes(accessor.where + " (sparse indices)", sparse.count, index_size, index_size, sparse.indices.size());
    require_bytes(accessor.where + " (sparse values)", sparse.count, element, element, sparse.values.size());
}

/// Calls store(element, bytes of that element) for the base and then for the sparse overlay.
template <typename Store>
void for_each_element(const Accessor& accessor, Store&& store) {
    if (accessor.has_bytes)
        for (std::size_t i = 0; i < accessor.count; ++i)
            store(i, accessor.bytes.data() + i * accessor.stride);
    if (!accessor.sparse)
        return;
    const SparseAccessor& sparse = *accessor.sparse;
    const std::size_t index_size = component_size(sparse.index_type);
    const std::size_t element = component_size(accessor.type) * static_cast<std::size_t>(accessor.components);
    for (std::size_t i = 0; i < sparse.count; ++i) {
        const std::uint8_t* at = sparse.indices.data() + i * index_size;
        const std::size_t index = with_component_type(
            sparse.index_type, [at](auto zero) { return static_cast<std::size_t>(load<decltype(zero)>(at)); });
        if (index >= accessor.count)
            throw InputError(expected_found(accessor.where + " (sparse)",
                                            "indices below " + std::to_string(accessor.count), std::to_string(index)));
        store(index, sparse.values.data() + i * element);
    }
}

template <int N>
std::vector<glm::vec<N, float>> read_vectors(const Accessor& accessor) {
    check(accessor, N);
    std::vector<glm::vec<N, float>> result;
    result.reserve(accessor.count + 1);
    result.resize(accessor.count, glm::vec<N, float>(0));
    with_component_type(accessor.type, [&](auto zero) {
        using T = decltype(zero);
        for_each_element(accessor, [&](std::size_t i, const std::uint8_t* bytes) {
            for (int c = 0; c < N; ++c)
                result[i][c] = to_float(load<T>(bytes + static_cast<std::size_t>(c) * sizeof(T)), accessor.normalised);
        });
    });
    for (std::size_t i = 0; i < result.size(); ++i)
        for (int c = 0; c < N; ++c)
            if (!std::isfinite(result[i][c]))
                throw InputError(expected_found(accessor.where + ", element " + std::to_string(i), "finite numbers",
                                                std::to_string(result[i][c])));
    return result;
}

}  // namespace

std::size_t component_size(ComponentType type) {
    return with_component_type(type, [](auto zero) { return sizeof zero; });
}

std::vector<glm::vec2> read_vec2(const Accessor& accessor) {
    return read_vectors<2>(accessor);
}

std::vector<glm::vec3> read_vec3(const Accessor& accessor) {
    return read_vectors<3>(accessor);
}

std::vector<std::uint32_t> read_indices(const Accessor& accessor) {
    if (accessor.type != ComponentType::u8 && accessor.type != ComponentType::u16 &&
        accessor.type != ComponentType::u32)
        throw InputError(expected_found(accessor.where, "unsigned integers as indices", "another component type"));
    check(accessor, 1);
    std::vector<std::uint32_t> result(accessor.count, 0);
    with_component_type(accessor.type, [&](auto zero) {
        for_each_element(accessor, [&](std::size_t i, const std::uint8_t* bytes) {
            result[i] = static_cast<std::uint32_t>(load<decltype(zero)>(bytes));
        });
    });
    return result;
}

}  // namespace equistream
