#pragma once
/// How visibly off a track's colours are, as the encoder measures it: by noise, by denoising and by coding. It is a
/// share of pixels for each amount of texture that is left to see around them. Nothing in the decoded picture says what
/// is wrong with it: only who has more can tell. With group "reference" (aov.h) all three are measured, without it
/// coding alone. Travels in frame data; the client's reliability map reads it. Pictures are display-referred sRGB,
/// 8-bit RGB or RGBA, of which the first three channels count. Pure functions; rows run in parallel.
#include <equistream/image.h>

#include <array>
#include <cstdint>
#include <optional>

namespace equistream {

/// The largest difference of a pixel's channels, in 1/255, to those of the pixels `step` to its left and right, and
/// above and below; along an axis where one of the two lies outside the picture nothing counts.
ByteImage contrast_of(ImageView<const std::uint8_t> pixels, int step);

/// Mean over the square that reaches so many pixels to either side, what of it lies in the picture.
FloatImage mean_around(const ByteImage& image, int reach);

/// Texture: log2(1 + x / 2) of x, the mean of contrast over a square of so many source pixels to either side.
inline constexpr int texture_steps = 4;

/// Of 255: 4 %, some three times what is just noticeable between flat patches side by side, and about what H.264 at CRF
/// 24 does to texture.
inline constexpr int visible_loss_255 = 10;

struct VisibleLoss {
    /// Textures of the decoded picture that it is given for; straight lines between them, the last one's beyond.
    static constexpr std::array<float, 8> textures = {0, 1, 2, 2.75f, 3.5f, 4.25f, 5, 6};
    /// 255 times the share of pixels of which a channel is off by more than visible_loss_255.
    std::array<std::uint8_t, textures.size()> share_255{};

    bool operator==(const VisibleLoss&) const = default;
};

/// Share, 0 to 1, for a texture of 0 or more.
float loss_at(const VisibleLoss& loss, float texture);

/// What H.264 at this CRF and preset medium takes where nobody measured it: a mean over the scenes of
/// docs/results/reproject/reliability.md at CRF 16 and 24, from which single ones differ by factors.
VisibleLoss usual_coding_loss(double crf);

/// Over all pictures that were added. A texture that hardly any of their pixels show has the loss of the nearest that
/// more do.
class VisibleLossMeter {
public:
    /// One picture before and after coding, of one size.
    void add(ImageView<const std::uint8_t> picture, ImageView<const std::uint8_t> decoded);
    /// One that is shown; RGBA of the same size: what it should be, where A is not 0; and that once more with noise of
    /// its own. A channel counts as off if it is above both, or below both, by too much: noise seldom makes it so.
    void add_reference(ImageView<const std::uint8_t> shown, ImageView<const std::uint8_t> reference,
                       ImageView<const std::uint8_t> repeat);
    /// By references; of textures that too few of them show, no less than coding took. Without any what coding took.
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
