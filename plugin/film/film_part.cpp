/// A frame in parts: what tiles of one part brought, as bytes, and taken up again.
#include "film.h"

#include <equistream/cryptomatte.h>
#include <equistream/error.h>

#include <bit>
#include <cassert>
#include <cstring>

namespace equistream {
namespace {

template <typename T>
std::span<std::byte> bytes_of(T* first, std::size_t count) {
    return std::as_writable_bytes(std::span(first, count));
}

}  // namespace

void Film::each_piece(const TileShare& share, const std::function<void(std::span<std::byte>)>& take) {
    start_once();
    for (std::uint32_t id = share.first; id < all_tiles(); id += share.step) {
        const es_tile of = tile(id);
        if (is_reference(id)) {
            for (std::uint32_t half = 0; half < reference_halves; ++half)
                take(bytes_of(reference_sum(of, half), of.pixel_count * reference_channels));
            continue;
        }
        const auto take_rows = [&](auto& image) {
            const auto samples = static_cast<std::size_t>(of.width) * static_cast<std::size_t>(image.channels());
            for (int y = of.y; y < of.y + of.height && image.width() > 0; ++y)
                take(bytes_of(image.pixel(of.x, y), samples));
        };
        take(bytes_of(&progress_[id].guide_passes, 1));
        take_rows(radiance_sum_);
        take_rows(left_out_);
        take_rows(guide_sum_);
        take_rows(answered_);
        for (auto& [name, plane] : real_)
            take_rows(plane);
        for (auto& [name, plane] : ids_)
            take_rows(plane);
    }
}

std::string Film::part_bytes() {
    assert(whole_.empty());
    std::string bytes;
    bytes.reserve(part_size(part_));
    each_piece(share_, [&](std::span<std::byte> piece) {
        bytes.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    });
    return bytes;
}

std::size_t Film::part_size(const FramePart& part) {
    std::size_t size = 0;
    each_piece(TileShare(part), [&](std::span<std::byte> piece) { size += piece.size(); });
    return size;
}

namespace {

/// Ids with how many samples met each.
bool has_sound_ids(const float* pairs, std::uint32_t samples) {
    for (int rank = 0; rank < cryptomatte_ranks; ++rank, pairs += 2) {
        const bool is_count = pairs[1] >= 0 && pairs[1] <= float(samples);
        if (!is_count || (pairs[1] > 0 && std::bit_cast<std::uint32_t>(pairs[0]) == 0))
            return false;
    }
    return true;
}

}  // namespace

void Film::put_part(const FramePart& part, const std::string& bytes) {
    const char* from = bytes.data();
    const TileShare share(part);
    each_piece(share, [&](std::span<std::byte> piece) {
        std::memcpy(piece.data(), from, piece.size());
        from += piece.size();
    });
    for (std::uint32_t id = share.first; id < all_tiles(); id += share.step) {
        TileProgress& progress = progress_[id];
        progress.colour_passes = passes_of(id);
        progress.surfaces = true;
        progress.id_passes = passes_of(id);
        bool is_sound = progress.guide_passes == 0 || progress.guide_passes == passes_of(id);
        const es_tile of = tile(id);
        for (std::uint32_t i = 0; i < of.pixel_count && !is_reference(id); ++i) {
            const glm::ivec2 at = TilePixels{of}.at(i);
            is_sound = is_sound && *left_out_.pixel(at.x, at.y) <= passes_of(id);
            for (const char* name : {"crypto_object", "crypto_material"})
                is_sound = is_sound && (real_target(name) == nullptr ||
                                        has_sound_ids(real_.at(name).pixel(at.x, at.y), passes_of(id)));
        }
        if (!is_sound)
            throw InputError(expected_found("tile " + std::to_string(id),
                                            "at most " + std::to_string(passes_of(id)) + " samples a pixel", "more"));
    }
}

}  // namespace equistream
