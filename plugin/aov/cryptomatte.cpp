#include <equistream/cryptomatte.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdio>
#include <set>
#include <tuple>

namespace equistream {

namespace {

/// Of a name in JSON: what cannot stand in a string there.
std::string escaped(const std::string& name) {
    std::string text;
    for (const char c : name) {
        if (c == '"' || c == '\\')
            text += '\\';
        if (static_cast<unsigned char>(c) < 0x20) {
            char code[8];
            std::snprintf(code, sizeof code, "\\u%04x", unsigned(c));
            text += code;
        } else {
            text += c;
        }
    }
    return text;
}

std::string hexadecimal(std::uint32_t number) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", number);
    return digits;
}

/// A dictionary of names and ids, each name once.
std::string manifest(const std::vector<std::string>& names) {
    std::string text;
    std::set<std::string> known;
    for (const std::string& name : names)
        if (known.insert(name).second)
            text += (text.empty() ? "\"" : ",\"") + escaped(name) + "\":\"" +
                    hexadecimal(std::bit_cast<std::uint32_t>(cryptomatte_id(name))) + "\"";
    return "{" + text + "}";
}

}  // namespace

std::uint32_t cryptomatte_hash(std::string_view name) {
    constexpr std::uint32_t c1 = 0xcc9e2d51, c2 = 0x1b873593;
    const auto mixed = [](std::uint32_t block) { return std::rotl(block * c1, 15) * c2; };
    const auto byte = [&](std::size_t i) { return std::uint32_t{static_cast<unsigned char>(name[i])}; };
    std::uint32_t hash = 0;
    std::size_t at = 0;
    for (; at + 4 <= name.size(); at += 4) {
        hash ^= mixed(byte(at) | byte(at + 1) << 8 | byte(at + 2) << 16 | byte(at + 3) << 24);
        hash = std::rotl(hash, 13) * 5 + 0xe6546b64;
    }
    std::uint32_t tail = 0;
    for (std::size_t i = name.size(); i-- > at;)
        tail = tail << 8 | byte(i);
    hash ^= mixed(tail);  // of no bytes: 0
    hash ^= static_cast<std::uint32_t>(name.size());
    hash = (hash ^ hash >> 16) * 0x85ebca6b;
    hash = (hash ^ hash >> 13) * 0xc2b2ae35;
    return hash ^ hash >> 16;
}

float cryptomatte_id(std::string_view name) {
    std::uint32_t bits = cryptomatte_hash(name);
    const std::uint32_t exponent = bits >> 23 & 255;
    if (exponent == 0 || exponent == 255)
        bits ^= 1u << 23;
    return std::bit_cast<float>(bits);
}

std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(std::span<const std::string> planes,
                                                                        const CryptomatteNames& names) {
    std::vector<std::pair<std::string, std::string>> attributes;
    for (const auto& [plane, type, of] : {std::tuple("crypto_object", "CryptoObject", &names.objects),
                                          {"crypto_material", "CryptoMaterial", &names.materials}}) {
        if (std::ranges::find(planes, plane) == planes.end())
            continue;
        const std::string key = "cryptomatte/" + hexadecimal(cryptomatte_hash(type)).substr(0, 7) + "/";
        attributes.emplace_back(key + "name", type);
        attributes.emplace_back(key + "hash", "MurmurHash3_32");
        attributes.emplace_back(key + "conversion", "uint32_to_float32");
        attributes.emplace_back(key + "manifest", manifest(*of));
    }
    return attributes;
}

}  // namespace equistream
