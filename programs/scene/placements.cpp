#include "placements.h"

#include <equistream/json_text.h>

#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>

namespace equistream {
namespace {

std::array<float, 16> numbers(const glm::mat4& matrix) {
    std::array<float, 16> result{};
    std::copy_n(glm::value_ptr(matrix), result.size(), result.begin());
    return result;
}

}  // namespace

std::string placements_json(const SceneModel& model) {
    nlohmann::json json = {{"objects", nlohmann::json::array()}, {"instances", nlohmann::json::array()}};
    for (const Object& object : model.objects)
        json["objects"].push_back({{"name", object.name},
                                   {"parent", object.parent},
                                   {"world_from_object", numbers(object.world_from_object)}});
    // A mesh without a material has the last one.
    const auto last = static_cast<std::uint32_t>(model.materials.size() - 1);
    for (const Instance& instance : model.instances)
        json["instances"].push_back({{"object", instance.object},
                                     {"material", std::min(model.meshes[instance.mesh].material, last)},
                                     {"world_from_object", numbers(instance.world_from_object)}});
    // Names come from files and need not be UTF-8.
    return json_text(json) + "\n";
}

}  // namespace equistream
