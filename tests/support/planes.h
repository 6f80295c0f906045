#pragma once
/// Memory for what depth codes fill.
#include <equistream/depth_code.h>

#include <array>

namespace equistream {

/// Owns the planes of a picture of even sides.
class Planes {
public:
    Planes(const PlaneFormat& format, int width, int height) : format_(format) {
        for (int i = 0; i < format.plane_count(); ++i) {
            const int w = width / format.step(i), h = height / format.step(i);
            if (format.bits == 8)
                bytes_[i] = Image<std::uint8_t>(w, h, 1);
            else
                words_[i] = Image<std::uint16_t>(w, h, 1);
        }
    }
    PlanesView view() {
        PlanesView planes{format_};
        for (int i = 0; i < format_.plane_count(); ++i) {
            planes.bytes[i] = bytes_[i].view();
            planes.words[i] = words_[i].view();
        }
        return planes;
    }

private:
    PlaneFormat format_;
    std::array<Image<std::uint8_t>, 3> bytes_;
    std::array<Image<std::uint16_t>, 3> words_;
};

}  // namespace equistream
