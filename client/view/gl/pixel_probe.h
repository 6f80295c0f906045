#pragma once
/// What is known of one pixel of an eye. It is read behind the GPU's work: asking waits for nothing, and the answer is
/// there a refresh or two later.
#include <client/gpu/objects.h>
#include <client/view/gl/display.h>
#include <client/warp/gl/eye_targets.h>

#include <array>
#include <cstdint>
#include <optional>

namespace equistream::gl {

struct PixelValues {
    ShownPixel pixel;
    std::array<std::uint8_t, 4> rgba{};  ///< display-referred sRGB
    std::uint8_t origin = 0;             ///< PixelOrigin
    std::optional<float> inverse_m;      ///< 1 over the planar depth, 0 for a miss; nothing: not known
    std::optional<float> reliability;    ///< 0 to 1; nothing: not estimated
};

class PixelProbe {
public:
    PixelProbe();
    ~PixelProbe();
    PixelProbe(const PixelProbe&) = delete;
    PixelProbe& operator=(const PixelProbe&) = delete;

    /// Of what was drawn last. `reliability` 0: not known. Nothing happens while an answer is being waited for.
    void ask(const ShownPixel& pixel, const EyeTargets& eyes, const EyeDepth& depth, GLuint reliability);
    /// It will be there without another ask().
    bool is_waiting() const { return fence_ != nullptr; }
    /// Once for each ask(), when the GPU is that far.
    std::optional<PixelValues> take();

private:
    Buffer buffer_;
    GLsync fence_ = nullptr;
    PixelValues asked_;
};

}  // namespace equistream::gl
