#include "loaded_scene.h"

#include <scenes/sky/sky_image.h>

#include <equistream/elapsed.h>

namespace equistream::embree_host {

namespace {

/// Equally far apart in time.
std::vector<glm::vec3> places_along(const PosePath& path) {
    constexpr int places = 64;
    std::vector<glm::vec3> found;
    for (int i = 0; i < places && !path.empty(); ++i)
        found.emplace_back(path.at(path.duration_s() * i / (places - 1)).position_m);
    return found;
}

}  // namespace

LoadedScene::LoadedScene(const SceneDescription& description, const PathOptions& options, const PosePath& path,
                         unsigned threads)
    : description_(description), model_(load_model(description)), moving_(find_moving_instances(model_, description)) {
    textures_.emplace(model_);
    shading_.emplace(model_);
    const auto bvh_start = Clock::now();
    bvh_.emplace(model_, BvhOptions{moving_, threads, shading_->has_thin_glass()});
    bvh_s_ = seconds_since(bvh_start);
    if (description.sun)
        lights_.sun.emplace(glm::vec3(description.sun->towards), glm::vec3(description.sun->irradiance),
                            static_cast<float>(description.sun->angular_radius_rad));
    lights_.sky = glm::vec3(description.sky_radiance);
    if (const auto& sky = description.sky_image)
        lights_.sky_image.emplace(read_sky_image(sky->file), sky->rotation_rad, glm::vec3(sky->scale));
    moves_.assign(model_.instances.size(), 0);
    for (const std::uint32_t instance : moving_)
        moves_[instance] = 1;
    now_ = instance_transforms(model_, description_, 0);
    lights_.emitters.build(*shading_, now_, *textures_);
    traced_.emplace(TracedScene{*bvh_, *shading_, *textures_, lights_, options});
    const auto openings_start = Clock::now();
    openings_ = learn_openings(*traced_, places_along(path), threads);
    openings_s_ = seconds_since(openings_start);
    traced_.emplace(TracedScene{*bvh_, *shading_, *textures_, lights_, options, &openings_});
}

void LoadedScene::move_to(double time_s, double previous_time_s, double next_time_s) {
    if (moving_.empty())
        return;
    now_ = instance_transforms(model_, description_, time_s);
    previous_ = instance_transforms(model_, description_, previous_time_s);
    next_ = instance_transforms(model_, description_, next_time_s);
    bvh_->move(now_);
    shading_->place_instances(now_);
    lights_.emitters.build(*shading_, now_, *textures_);
}

}  // namespace equistream::embree_host
