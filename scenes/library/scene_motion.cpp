#include "scene.h"

#include <equistream/error.h>

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace equistream {

namespace {

/// Scale of a transform along its own axes, a mirror image counted on the first; shear is lost.
glm::dvec3 scale_of(const glm::dmat4& m) {
    glm::dvec3 scale(glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])), glm::length(glm::dvec3(m[2])));
    if (glm::determinant(glm::dmat3(m)) < 0)
        scale.x = -scale.x;
    return scale;
}

/// For each moving entry the object it names.
std::unordered_map<std::uint32_t, std::size_t> moving_objects(const SceneModel& model, const SceneDescription& scene) {
    std::unordered_map<std::string_view, std::vector<std::uint32_t>> named;
    for (const MovingObject& moving : scene.moving)
        named[moving.object];
    for (std::uint32_t object = 0; object < model.objects.size(); ++object)
        if (const auto entry = named.find(model.objects[object].name); entry != named.end())
            entry->second.push_back(object);
    std::unordered_map<std::uint32_t, std::size_t> entry_of_object;
    for (std::size_t entry = 0; entry < scene.moving.size(); ++entry) {
        const std::string& name = scene.moving[entry].object;
        const std::vector<std::uint32_t>& found = named[name];
        if (found.size() != 1)
            throw InputError(expected_found(scene.file.string(), "one node named \"" + name + "\" in the model",
                                            found.empty() ? "none" : "several"));
        if (!std::isnormal(glm::determinant(glm::mat3(model.objects[found.front()].world_from_object))))
            throw InputError(expected_found(scene.file.string(), "a node of some volume to move", "\"" + name + "\""));
        entry_of_object[found.front()] = entry;
    }
    return entry_of_object;
}

/// For each object the nearest of it and its parents that moves by itself; no_index where none does.
std::vector<std::uint32_t> movers(const SceneModel& model,
                                  const std::unordered_map<std::uint32_t, std::size_t>& moving) {
    constexpr std::uint32_t unknown = no_index - 1;
    std::vector<std::uint32_t> mover_of_object(model.objects.size(), unknown);
    std::vector<std::uint32_t> chain;  // up to an object whose mover is known
    for (std::uint32_t object = 0; object < model.objects.size(); ++object) {
        std::uint32_t mover = no_index;
        for (int o = static_cast<int>(object); o >= 0; o = model.objects[static_cast<std::size_t>(o)].parent) {
            const auto index = static_cast<std::uint32_t>(o);
            if (mover_of_object[index] != unknown) {
                mover = mover_of_object[index];
                break;
            }
            chain.push_back(index);
            if (moving.contains(index)) {
                mover = index;
                break;
            }
        }
        for (const std::uint32_t one : chain)
            mover_of_object[one] = mover;
        chain.clear();
    }
    return mover_of_object;
}

}  // namespace

std::vector<std::uint32_t> find_moving_instances(const SceneModel& model, const SceneDescription& scene) {
    const auto moving = moving_objects(model, scene);
    std::vector<std::uint32_t> instances;
    if (moving.empty())
        return instances;
    const std::vector<std::uint32_t> mover_of_object = movers(model, moving);
    for (std::uint32_t i = 0; i < model.instances.size(); ++i)
        if (mover_of_object[model.instances[i].object] != no_index)
            instances.push_back(i);
    return instances;
}

MovedInstances::MovedInstances(const SceneModel& model, const SceneDescription& scene) {
    const auto moving = moving_objects(model, scene);
    std::unordered_map<std::uint32_t, std::size_t> place_of_mover;
    for (const auto& [object, entry] : moving) {
        const glm::dmat4 rest(model.objects[object].world_from_object);
        place_of_mover[object] = movers_.size();
        movers_.push_back({scene.moving[entry].path, scale_of(rest), glm::inverse(rest)});
    }
    const std::vector<std::uint32_t> mover_of_object = movers(model, moving);
    for (const Instance& instance : model.instances) {
        const std::uint32_t mover = mover_of_object[instance.object];
        if (mover != no_index)
            moving_.push_back(
                {world_from_object_.size(), place_of_mover[mover], glm::dmat4(instance.world_from_object)});
        world_from_object_.push_back(instance.world_from_object);
    }
}

const std::vector<glm::mat4>& MovedInstances::at(double time_s) {
    for (Mover& mover : movers_) {
        const Pose pose = mover.path.at(time_s);
        mover.moved_from_rest = glm::translate(glm::dmat4(1), pose.position_m) * glm::mat4_cast(pose.orientation) *
                                glm::scale(glm::dmat4(1), mover.scale) * mover.object_from_rest;
    }
    for (const Moving& one : moving_)
        world_from_object_[one.instance] = glm::mat4(movers_[one.mover].moved_from_rest * one.rest);
    return world_from_object_;
}

std::vector<glm::mat4> instance_transforms(const SceneModel& model, const SceneDescription& scene, double time_s) {
    return MovedInstances(model, scene).at(time_s);
}

}  // namespace equistream
