#pragma once
/// Fields of a few bits in frame data: the lowest bit of each byte first, and of each field.
#include <equistream/error.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace equistream {

/// Appends to the bytes it was given, beginning with a byte of its own.
class BitWriter {
public:
    explicit BitWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

    void put(std::uint32_t value, int bits) {
        for (int i = 0; i < bits; ++i, ++count_) {
            if (count_ % 8 == 0)
                bytes_.push_back(0);
            bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | ((value >> i & 1u) << count_ % 8));
        }
    }
    /// Exp-Golomb, below 2^31: n zeros, a one, and the n lower bits of value + 1.
    void put_count(std::uint32_t value) {
        const int lower = std::bit_width(value + 1) - 1;
        put(0, lower);
        put(1, 1);
        put(value + 1, lower);
    }
    /// The same of 0, 1, -1, 2, -2 ...; of magnitudes below 2^30.
    void put_difference(std::int32_t value) {
        put_count(value > 0 ? 2 * std::uint32_t(value) - 1 : 2 * std::uint32_t(-value));
    }

private:
    std::vector<std::uint8_t>& bytes_;
    unsigned count_ = 0;
};

/// Throws WorkError, with `place` before the colon, for what is not there or is none of these fields.
class BitReader {
public:
    BitReader(std::span<const std::uint8_t> bytes, const char* place) : bytes_(bytes), place_(place) {}

    std::uint32_t get(int bits) {
        if (at_ + static_cast<std::size_t>(bits) > bytes_.size() * 8)
            throw WorkError(expected_found(place_, "more bytes", std::to_string(bytes_.size())));
        std::uint32_t value = 0;
        for (int i = 0; i < bits; ++i, ++at_)
            value |= (bytes_[at_ / 8] >> at_ % 8 & 1u) << i;
        return value;
    }
    std::uint32_t get_count() {
        int lower = 0;
        for (; get(1) == 0; ++lower)
            if (lower == 30)
                throw WorkError(expected_found(place_, "a number below 2^31", "31 zeros in a row"));
        return (1u << lower | get(lower)) - 1;
    }
    std::int32_t get_difference() {
        const std::uint32_t count = get_count();
        const auto half = static_cast<std::int32_t>(count / 2);
        return count % 2 == 1 ? half + 1 : -half;
    }

private:
    std::span<const std::uint8_t> bytes_;
    const char* place_;
    std::size_t at_ = 0;
};

}  // namespace equistream
