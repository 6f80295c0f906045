#pragma once
/// Structs that grow: a caller built with an older header hands over a shorter one.
#include <equistream/error.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

namespace equistream {

/// The struct with 0 where the host's header had no field yet; what a later header than ours appended is ignored.
/// Throws InputError for NULL and for a struct shorter than it ever was.
template <typename Struct>
Struct whole_struct(const Struct* of_host, const char* name, std::span<const std::size_t> sizes) {
    static_assert(std::is_trivially_copyable_v<Struct>);
    if (of_host == nullptr)
        throw InputError(expected_found(name, "a pointer", "NULL"));
    std::size_t size = 0;
    std::memcpy(&size, of_host, sizeof size);  // every one of them begins with its size
    std::size_t known = 0;
    for (const std::size_t each : sizes)
        if (each <= size)
            known = each;
    if (known == 0)
        throw InputError(expected_found(std::string(name) + ".struct_size", "at least " + std::to_string(sizes.front()),
                                        std::to_string(size)));
    Struct whole{};
    std::memcpy(&whole, of_host, known);
    return whole;
}

}  // namespace equistream
