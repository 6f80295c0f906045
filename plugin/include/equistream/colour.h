#pragma once
/// Display transform by OpenColorIO: scene-referred linear Rec.709 <-> display-referred sRGB.
/// The default view is the plain sRGB encoding of exposed, clipped radiance, so that the client can undo it.
/// Objects are immutable after construction; apply and invert may run on any number of threads.
#include <equistream/image.h>

#include <memory>
#include <string>
#include <vector>

namespace equistream {

inline constexpr const char* default_view = "Un-tone-mapped";

class DisplayTransform {
public:
    /// `view` is a view of the bundled OpenColorIO config's sRGB display; throws InputError with the accepted names.
    explicit DisplayTransform(const std::string& view = default_view);
    ~DisplayTransform();
    DisplayTransform(DisplayTransform&&) noexcept;

    /// exposure * linear RGB(A) -> display RGB in [0, 1]. `linear` has 3 or 4 channels, the result 3.
    FloatImage to_display(ImageView<const float> linear, double exposure) const;
    /// The inverse, for display values in [0, 1].
    FloatImage to_linear(ImageView<const float> display, double exposure) const;

private:
    struct Processors;
    std::unique_ptr<Processors> processors_;
};

/// Round to 8 bits: floor(255 x + 1/2), clamped; NaN is 0.
ByteImage quantise_8bit(ImageView<const float> display);
FloatImage widen_8bit(ImageView<const std::uint8_t> display);

}  // namespace equistream
