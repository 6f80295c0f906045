#pragma once
#include "fill.h"

#include <cstddef>

namespace equistream {

/// The client's own geometry, lit as what is seen of the same instance around a gap: linear colour = base colour there
/// times seen over base colour of the nearest filled pixels of that instance. What shines by itself, mirrors or is
/// glass, what nothing hits, and instances that nothing is seen of nearby stay gaps.
class GeometryPass : public FillPass {
public:
    std::string_view name() const override { return "geometry"; }
    bool wants_depth() const override { return false; }
    void set_frame(const FillInputs& inputs) override { geometry_ = inputs.geometry; }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    GeometryColour* geometry_ = nullptr;
};

// Numbers of the `geometry` fill pass: where light is looked for that a gap's surface receives.

inline constexpr int light_tile_side = 8;
inline constexpr int light_sample_step = 2;    ///< of filled pixels, those at every second column and row are asked
inline constexpr int lit_tiles_around = 2;     ///< a tile with gaps: those whose samples are asked
inline constexpr int farthest_light_tile = 6;  ///< around a gap's own where its instance is looked for
inline constexpr std::size_t enough_light_samples = 12;
inline constexpr float min_base = 0.02f;  ///< darker surfaces' colours say little about their light
inline constexpr float min_light_weight = 1e-3f;

}  // namespace equistream
