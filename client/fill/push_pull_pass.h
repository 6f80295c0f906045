#pragma once
#include "push_pull.h"
#include "seen_points.h"

#include "fill.h"

namespace equistream {

/// Coarser levels of the picture itself.
class PushPullPass : public FillPass {
public:
    std::string_view name() const override { return "pushpull"; }
    bool wants_depth() const override { return false; }
    void set_frame(const FillInputs& inputs) override { inputs_ = inputs; }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    struct Workspace {
        PushPull pyramid;
        FloatImage background_m;
    };
    glm::dvec3 towards_source(const EyeView& eye) const;

    FillInputs inputs_;
    mutable ObjectPool<Workspace> pool_;
};

}  // namespace equistream
