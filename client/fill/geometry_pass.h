#pragma once
#include "fill.h"

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

}  // namespace equistream
