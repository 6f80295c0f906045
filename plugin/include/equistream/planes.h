#pragma once
/// Pictures as video codecs take and give them: one to three planes of 8-bit bytes, or of words that hold 9 to 16 bits.
/// Views borrow their samples.
#include <equistream/image.h>

#include <array>

namespace equistream {

/// gray: one plane. yuv420: y, cb, cr, those of chroma half as wide and high. yuv444, gbr: three of one size.
enum class PlaneLayout { gray, yuv420, yuv444, gbr };

struct PlaneFormat {
    PlaneLayout layout = PlaneLayout::gray;
    int bits = 8;  ///< of each sample, in the low bits of a byte or word

    int plane_count() const { return layout == PlaneLayout::gray ? 1 : 3; }
    /// Of chroma planes, in pixels a sample; 1 for all others.
    int step(int plane) const { return layout == PlaneLayout::yuv420 && plane > 0 ? 2 : 1; }
    bool operator==(const PlaneFormat&) const = default;
};

/// `Byte` and `Word` are std::uint8_t and std::uint16_t, or const. Only one of the two arrays is used.
template <typename Byte, typename Word>
struct AnyPlanesView {
    PlaneFormat format;
    std::array<ImageView<Byte>, 3> bytes{};  ///< of 8-bit formats, one channel each
    std::array<ImageView<Word>, 3> words{};  ///< of all others

    operator AnyPlanesView<const Byte, const Word>() const {
        return {format, {bytes[0], bytes[1], bytes[2]}, {words[0], words[1], words[2]}};
    }
};
using PlanesView = AnyPlanesView<std::uint8_t, std::uint16_t>;
using ConstPlanesView = AnyPlanesView<const std::uint8_t, const std::uint16_t>;

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
