#pragma once
#include "fill.h"

namespace equistream {

/// The nearest filled neighbours.
class SpreadPass : public FillPass {
public:
    std::string_view name() const override { return "spread"; }
    bool wants_depth() const override { return false; }
    void set_frame(const FillInputs&) override {}
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;
};

}  // namespace equistream
