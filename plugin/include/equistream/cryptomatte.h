#pragma once
/// Cryptomatte 1.2.0 (Psyop, "Cryptomatte Specification"): which objects and materials a pixel shows, and how much of
/// it each covers, by names that compositing programs read. Pure functions.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace equistream {

/// Objects or materials of a pixel that are kept, the first ones that its samples meet: three layers of two.
inline constexpr int cryptomatte_ranks = 6;

/// MurmurHash3_x86_32 with seed 0, of the bytes of UTF-8.
std::uint32_t cryptomatte_hash(std::string_view name);

/// What pixels hold for a name: the hash's bits as a float ("uint32_to_float32"), with the lowest bit of the exponent
/// changed where it would be no normal number.
float cryptomatte_id(std::string_view name);

/// Names by their ids less 1; those that have none are called after their number.
struct CryptomatteNames {
    std::vector<std::string> objects, materials;
};

/// What a file with these planes of the AOV catalogue says of them: attributes and their texts, none where it has no
/// such plane.
std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(std::span<const std::string> planes,
                                                                        const CryptomatteNames& names);

}  // namespace equistream
