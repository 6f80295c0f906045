#include "bench_scene.h"

#include <equistream_generate/generate.h>

#include <cstdlib>
#include <map>
#include <memory>

#include <unistd.h>

namespace equistream::bench {

namespace {

SceneModel without_masks(SceneModel model) {
    for (Material& material : model.materials)
        material.alpha_mask = no_index;
    return model;
}

BvhOptions options_of(const SceneModel& model, const SceneDescription& description) {
    return {.moving_instances = find_moving_instances(model, description)};
}

std::unique_ptr<BenchScene> generated(const std::string& name) {
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("equistream-bench-" + std::to_string(getpid()));
    auto scene = std::make_unique<BenchScene>(write_scene(make_scene(find_generator(name)), folder));
    std::filesystem::remove_all(folder);
    return scene;
}

std::unique_ptr<BenchScene> load(const std::string& name) {
    if (name == "pavilion")
        return generated(name);
    const char* scenes = std::getenv("EQUISTREAM_SCENES");
    if (scenes == nullptr || *scenes == '\0')
        return nullptr;
    return std::make_unique<BenchScene>(std::filesystem::path(EQUISTREAM_DESCRIPTIONS) / (name + ".json"));
}

}  // namespace

BenchScene::BenchScene(const std::filesystem::path& description_file)
    : description(load_scene(description_file)), depth(description), carried_depth(description, {.reuse = true}),
      model(load_model(description.model, {.shading = false})), model_without_masks(without_masks(model)),
      bvh(model, options_of(model, description)),
      bvh_without_masks(model_without_masks, options_of(model_without_masks, description)) {}

BenchScene* bench_scene(const std::string& name) {
    static std::map<std::string, std::unique_ptr<BenchScene>> scenes;
    const auto [scene, added] = scenes.try_emplace(name);
    if (added)
        scene->second = load(name);
    return scene->second.get();
}

}  // namespace equistream::bench
