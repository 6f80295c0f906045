#pragma once
/// What eye_rays.glsl knows of the eyes: how they look at one source.
#include "eye_targets.h"

#include <equistream/bound.h>

#include <span>

namespace equistream::gl {

class EyeBlocks {
public:
    EyeBlocks();

    /// Of up to max_eyes eyes; `error_budget_px` as in EngineOptions.
    void set(const SourceView& source, std::span<const EyeView> eyes, double error_budget_px = default_error_budget_px);
    /// Each eye and the source that it looks at, all with one head box.
    void set(std::span<const Pose> sources, double box_radius_m, std::span<const EyeView> eyes,
             double error_budget_px = default_error_budget_px);
    GLuint name() const { return blocks_.name(); }

private:
    Buffer blocks_;
};

}  // namespace equistream::gl
