#include "bench_scene.h"

#include <scenes/generate/generate.h>

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

/// The bundled scene's files, for as long as the program runs.
struct WrittenScene {
    WrittenScene()
        : folder(std::filesystem::temp_directory_path() / ("equistream-bench-" + std::to_string(getpid()))),
          description(write_scene(make_scene(find_generator("pavilion")), folder)) {}
    ~WrittenScene() { std::filesystem::remove_all(folder); }
    WrittenScene(const WrittenScene&) = delete;
    WrittenScene& operator=(const WrittenScene&) = delete;

    std::filesystem::path folder, description;
};

}  // namespace

std::optional<SceneDescription> bench_description(const std::string& name) {
    if (name == "pavilion") {
        static const WrittenScene pavilion;
        return load_scene(pavilion.description);
    }
    const char* scenes = std::getenv("EQUISTREAM_SCENES");
    if (scenes == nullptr || *scenes == '\0')
        return std::nullopt;
    return load_scene(std::filesystem::path(EQUISTREAM_DESCRIPTIONS) / (name + ".json"));
}

BenchScene::BenchScene(const SceneDescription& scene)
    : description(scene), depth(description), model(load_model(description.model, {.shading = false})),
      model_without_masks(without_masks(model)), bvh(model, options_of(model, description)),
      bvh_without_masks(model_without_masks, options_of(model_without_masks, description)) {}

BenchScene* bench_scene(const std::string& name) {
    static std::map<std::string, std::unique_ptr<BenchScene>> scenes;
    const auto [scene, added] = scenes.try_emplace(name);
    if (added)
        if (const std::optional<SceneDescription> description = bench_description(name))
            scene->second = std::make_unique<BenchScene>(*description);
    return scene->second.get();
}

}  // namespace equistream::bench
