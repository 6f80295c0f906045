#pragma once
/// Makes the depth source that was chosen.
#include "modules.h"

#include <equistream/frame.h>

#include <memory>
#include <string>
#include <string_view>

namespace equistream {

struct MadeDepth {
    std::unique_ptr<DepthSource> source{};  ///< null: depth none
    ExactDepth* planes = nullptr;           ///< `source`, where that hands out what came with the frames
    bool casts_any_view = false;            ///< there is geometry: no view is without depth
    std::string driver{};                   ///< whose OpenGL draws it; empty: nobody's
    double load_ms = 0;                     ///< to load the scene
};

/// `depth`: of depth_stages(), or none. `scene` may be null where the depth needs none; where there is one, views that
/// came without depth are cast into it. Throws as the module's functions do, and InputError where a module is missing.
MadeDepth make_depth(std::string_view depth, const SceneDescription* scene, const FrameInfo& first,
                     const GeometryModules& modules);

}  // namespace equistream
