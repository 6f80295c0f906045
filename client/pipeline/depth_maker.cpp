#include "depth_maker.h"

#include <client/stages/stages.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>

#include <algorithm>
#include <array>
#include <utility>

namespace equistream {

namespace {

/// What a row of the table makes its depth source of.
struct DepthInputs {
    const SceneDescription* scene;
    const FrameInfo& first;
    const GeometryModules& modules;
};

/// The scene's rays; null: there is no scene.
std::unique_ptr<DepthSource> rays(const DepthInputs& inputs) {
    if (inputs.scene == nullptr)
        return nullptr;
    if (inputs.modules.ray.depth == nullptr)
        throw InputError(expected_found("depth of a scene", "the client's Embree module", "none"));
    return inputs.modules.ray.depth(*inputs.scene);
}

MadeDepth make_ray_depth(const DepthInputs& inputs) {
    return {.source = rays(inputs)};
}

MadeDepth drawn(const DepthInputs& inputs, bool cube) {
    if (inputs.modules.drawn == nullptr)
        throw InputError(expected_found("depth drawn by OpenGL", "the client's OpenGL module", "none"));
    DrawnDepth drawing = inputs.modules.drawn(*inputs.scene, cube, head_box_radius(inputs.first));
    return {.source = std::move(drawing.source), .driver = std::move(drawing.driver)};
}

MadeDepth make_drawn_depth(const DepthInputs& inputs) {
    return drawn(inputs, false);
}

MadeDepth make_drawn_cube_depth(const DepthInputs& inputs) {
    return drawn(inputs, true);
}

template <typename Planes>
MadeDepth make_planes(const DepthInputs& inputs) {
    auto planes = std::make_unique<Planes>(rays(inputs));
    Planes* const borrowed = planes.get();
    return {.source = std::move(planes), .planes = borrowed};
}

MadeDepth make_stream_depth(const DepthInputs& inputs) {
    return make_planes<StreamDepth>(inputs);
}

MadeDepth make_exact_depth(const DepthInputs& inputs) {
    return make_planes<ExactDepth>(inputs);
}

struct DepthRow {
    std::string_view name;
    MadeDepth (*make)(const DepthInputs& inputs);
};

#define DEPTH_SOURCE(name, help, giver, function) DepthRow{name, function},
constexpr std::array rows = {
#include <client/stages/stage_rows.inc>
};
#undef DEPTH_SOURCE

}  // namespace

MadeDepth make_depth(std::string_view depth, const SceneDescription* scene, const FrameInfo& first,
                     const GeometryModules& modules) {
    if (depth == "none")
        return {};
    const auto row = std::ranges::find(rows, find_depth(depth).name, &DepthRow::name);
    const auto start = Clock::now();
    MadeDepth made = row->make({scene, first, modules});
    made.load_ms = scene != nullptr ? milliseconds_since(start) : 0;
    made.casts_any_view = scene != nullptr;
    return made;
}

}  // namespace equistream
