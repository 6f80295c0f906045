#include "foreign_exr.h"

#include <equistream/error.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace equistream::files {

namespace {

constexpr std::uint32_t magic = 20000630, multi_part = 0x1000;
constexpr int longest_name = 255, max_attributes = 65536;

struct FixedType {
    std::string_view name;
    int bytes;
};

constexpr FixedType fixed_types[] = {{"box2i", 16},
                                     {"box2f", 16},
                                     {"chromaticities", 32},
                                     {"compression", 1},
                                     {"deepImageState", 1},
                                     {"double", 8},
                                     {"envmap", 1},
                                     {"float", 4},
                                     {"int", 4},
                                     {"keycode", 28},
                                     {"lineOrder", 1},
                                     {"m33f", 36},
                                     {"m33d", 72},
                                     {"m44f", 64},
                                     {"m44d", 128},
                                     {"rational", 8},
                                     {"tiledesc", 9},
                                     {"timecode", 8},
                                     {"v2i", 8},
                                     {"v2f", 8},
                                     {"v2d", 16},
                                     {"v3i", 12},
                                     {"v3f", 12},
                                     {"v3d", 24}};
constexpr int bytes_of_a_channel = 16;

/// As OpenEXR's file layout describes headers: names and types end in 0, sizes are four bytes, least significant first.
class HeaderScan {
public:
    HeaderScan(const std::filesystem::path& file, std::uintmax_t bytes)
        : file_(file), in_(file, std::ios::binary), bytes_(std::int64_t(bytes)) {}

    void check() {
        if (number() != magic)
            refuse("an EXR file", "other first bytes");
        const bool has_parts = (number() & multi_part) != 0;
        // A header ends with an empty name; several end with an empty header.
        while (skip_header() && has_parts)
            continue;
    }

private:
    /// Whether it had attributes.
    bool skip_header() {
        const int before = attributes_;
        while (!name().empty()) {
            if (++attributes_ > max_attributes)
                refuse("at most " + std::to_string(max_attributes) + " attributes", "more");
            const std::string type = name();
            const std::uint32_t size = number();
            const std::int64_t start = in_.tellg();
            if (std::int64_t{size} > bytes_ - start)
                refuse("attributes no longer than the file", std::to_string(size) + " bytes");
            // OpenEXR goes on behind what it read of a type that it knows, whatever the size says.
            if (const std::int64_t read = bytes_of(type, size); read != std::int64_t{size})
                refuse("an attribute of type " + type + " with " + std::to_string(read) + " bytes",
                       std::to_string(size));
            in_.seekg(start + std::int64_t{size});
        }
        return attributes_ > before;
    }

    /// What OpenEXR reads of a value.
    std::int64_t bytes_of(const std::string& type, std::uint32_t size) {
        const auto known = std::ranges::find(fixed_types, type, &FixedType::name);
        if (known != std::end(fixed_types))
            return known->bytes;
        const std::int64_t start = in_.tellg();
        if (type == "chlist") {
            while (!name().empty())
                in_.seekg(bytes_of_a_channel, std::ios::cur);
            return std::int64_t(in_.tellg()) - start;
        }
        if (type == "preview") {
            const std::int64_t width = number(), height = number();
            return height == 0 || width <= bytes_ / height ? 8 + 4 * width * height : std::int64_t{size} + 1;
        }
        return size;
    }

    std::string name() {
        std::string text;
        for (int c = in_.get(); c != 0; c = in_.get()) {
            if (c == std::char_traits<char>::eof() || text.size() > longest_name)
                refuse("a whole EXR header", "one that ends early");
            text += static_cast<char>(c);
        }
        return text;
    }

    std::uint32_t number() {
        std::array<char, 4> raw{};
        if (!in_.read(raw.data(), raw.size()))
            refuse("a whole EXR header", "one that ends early");
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < raw.size(); ++i)
            value |= std::uint32_t(static_cast<unsigned char>(raw[i])) << (8 * i);
        return value;
    }

    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw InputError(expected_found(file_.string(), expected, found));
    }

    const std::filesystem::path& file_;
    std::ifstream in_;
    std::int64_t bytes_;
    int attributes_ = 0;
};

}  // namespace

void require_attributes_within(const std::filesystem::path& file, std::uintmax_t file_bytes) {
    HeaderScan(file, file_bytes).check();
}

}  // namespace equistream::files
