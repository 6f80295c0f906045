#pragma once
/// Visible errors of a track's colours, from noise, denoising and coding. They are given as the share of wrong pixels
/// for each amount of texture around a pixel. The encoder measures them, because a decoded picture does not show its
/// own errors: all three with group "reference" (aov.h), coding alone without it. Frame data carry them, and the
/// client's confidence map uses them. Pictures are display-referred sRGB, 8-bit RGB or RGBA, of which the first three
/// channels count. Pure functions; rows run in parallel.
#include <equistream/image.h>

#include <array>
#include <cstdint>
#include <optional>

namespace equistream {

/// Contrast, 0 to 255: the largest difference of a pixel's channels to the pixels `step` (at least 1) to its left and
/// right, and above and below. An axis on which one of the two lies outside the picture does not count.
ByteImage contrast_of(ImageView<const std::uint8_t> pixels, int step);

/// Mean over the square that extends `reach` pixels to either side of a pixel, within the picture.
FloatImage mean_around(const ByteImage& image, int reach);

/// The texture around a pixel is log2(1 + x / 2). Here x is the mean of contrast_of(step 1) over the square that
/// extends so many source pixels to either side.
inline constexpr int texture_steps = 4;

/// A pixel is wrong if a channel is off by more than this, of 255. It is 4 %: about three times the difference that is
/// just noticeable between adjacent flat areas, and about the error of H.264 at CRF 24 in texture.
inline constexpr int visible_loss_255 = 10;

struct VisibleLoss {
    /// The textures of the decoded picture at which shares are given; linear between them, constant beyond the last.
    static constexpr std::array<float, 8> textures = {0, 1, 2, 2.75f, 3.5f, 4.25f, 5, 6};
    /// 255 times the share of wrong pixels, for each of `textures`.
    std::array<std::uint8_t, textures.size()> share_255{};

    bool operator==(const VisibleLoss&) const = default;
};

/// Share of wrong pixels, 0 to 1, for a texture of 0 or more.
float loss_at(const VisibleLoss& loss, float texture);

/// Estimated errors of H.264 at this CRF and preset medium, for streams without a measurement. Fitted to the mean over
/// the scenes of docs/results/reproject/reliability.md at CRF 16 and 24; single scenes differ from it by factors.
VisibleLoss usual_coding_loss(double crf);

/// Measures the visible errors over all pictures that are added. A texture with fewer than 100 pixels takes the share
/// of the nearest texture that has as many. One object, one thread.
class VisibleLossMeter {
public:
    /// Adds a picture before and after coding, of one size.
    void add(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> decoded);
    /// Adds a decoded picture with its references: the true colours in RGBA of the same size, valid where A is not 0,
    /// and a second estimate of them with independent noise. A channel is wrong if it is above both or below both by
    /// more than visible_loss_255, so the noise of the references seldom counts.
    void add_reference(ImageView<const std::uint8_t> shown, ImageView<const std::uint8_t> reference,
                       ImageView<const std::uint8_t> repeat);
    /// The errors by the references. A texture with too few reference pixels has at least the errors of coding. Without
    /// references: the errors of coding.
    VisibleLoss loss() const;

private:
    using ByTexture = std::array<double, VisibleLoss::textures.size()>;
    struct Sums {
        ByTexture lost{}, pixels{};
        /// Nothing where no texture has enough pixels.
        std::optional<VisibleLoss> loss() const;
    };
    Sums coded_, referred_;
};

}  // namespace equistream
