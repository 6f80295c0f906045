#include "foreign_exr.h"

#include <equistream/error.h>

#include <array>
#include <fstream>
#include <string>

namespace equistream::files {

namespace {

constexpr std::uint32_t magic = 20000630, multi_part = 0x1000;
constexpr int longest_name = 255, max_attributes = 65536;

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
            name();  // of the type
            const std::uint32_t size = number();
            if (std::int64_t{size} > bytes_ - std::int64_t(in_.tellg()))
                refuse("attributes no longer than the file", std::to_string(size) + " bytes");
            in_.seekg(size, std::ios::cur);
        }
        return attributes_ > before;
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
