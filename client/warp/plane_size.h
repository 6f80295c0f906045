#pragma once
/// What is gathered from by index must have the size that indices are made for: nothing else would stop at its ends.
#include <equistream/error.h>
#include <equistream/image.h>
#include <equistream/text.h>

#include <string>

namespace equistream {

struct PlaneSize {
    int width, height, channels;
    bool operator==(const PlaneSize&) const = default;
};

/// Throws InputError.
template <typename Sample>
void require_plane_size(const char* plane, const ImageView<Sample>& image, const PlaneSize& wanted) {
    const auto words = [](const PlaneSize& size) {
        return size_text(size.width, size.height) + " of " + std::to_string(size.channels);
    };
    const PlaneSize found{image.width, image.height, image.channels};
    if (found != wanted)
        throw InputError(
            expected_found(plane, words(wanted) + (wanted.channels == 1 ? " channel" : " channels"), words(found)));
}

}  // namespace equistream
