#pragma once
/// Which nodes a scene's model has and where its instances stand, as JSON: what a renderer in another process needs to
/// move objects and to number surfaces as ours does.
#include <scenes/library/scene.h>

#include <string>

namespace equistream {

/// {"objects": [{"name", "parent", "world_from_object"}], "instances": [{"object", "material", "world_from_object"}]};
/// matrices are 16 numbers, column by column.
std::string placements_json(const SceneModel& model);

}  // namespace equistream
