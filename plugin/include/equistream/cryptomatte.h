#pragma once
/// Cryptomatte 1.2.0 (Psyop, "Cryptomatte Specification"): the objects and materials in each pixel, by name, with their
/// coverage. Compositing programs read it. Pure functions.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace equistream {

/// How many objects, and how many materials, a pixel keeps: the first ones that its samples hit. Each of three EXR
/// layers holds two.
inline constexpr int cryptomatte_ranks = 6;

/// MurmurHash3_x86_32 of the name's UTF-8 bytes, with seed 0.
std::uint32_t cryptomatte_hash(std::string_view name);

/// The id that pixels hold for a name: the hash's bits as a float ("uint32_to_float32"). If these are no normal number,
/// the lowest bit of the exponent is flipped.
float cryptomatte_id(std::string_view name);

/// Element i names id i + 1. An id beyond the end is called by its number, such as "object 7"; an empty string is an
/// empty name.
struct CryptomatteNames {
    std::vector<std::string> objects, materials;
};

/// EXR attributes (name, text) that the specification requires for those of `planes` that are Cryptomattes; none if
/// there is no such plane. `planes` are names of the AOV catalogue.
std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(std::span<const std::string> planes,
                                                                        const CryptomatteNames& names);

}  // namespace equistream
