#pragma once
/// Figures of a scene: what it costs and what the bound (bound.h) asks of a sphere rendered in it.
#include <scenes/library/scene.h>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <limits>
#include <span>
#include <string>

namespace equistream {

/// Nothing lies in it until a point is added.
struct WorldBox {
    glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};

    void add(const glm::dvec3& p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    double distance(const glm::dvec3& p) const {
        return glm::length(glm::max(glm::dvec3(0), glm::max(low - p, p - high)));
    }
};

/// Of the corners of all triangles, one transform an instance.
WorldBox bounds_of(const SceneModel& model, std::span<const glm::mat4> world_from_object);

/// Triangles that emit light, with instances.
std::uint64_t emissive_triangles(const SceneModel& model);

/// What a live server of a few spheres a second is late by.
inline constexpr double window_delay_s = 0.25;

struct SceneSummary {
    std::string name;
    std::uint64_t triangles = 0;  ///< with instances
    std::uint64_t unique_triangles = 0;
    std::size_t meshes = 0, instances = 0, objects = 0, materials = 0, masked_materials = 0, textures = 0;
    std::uint64_t texture_bytes = 0;  ///< encoded
    bool has_sun = false, has_sky = false;
    std::string sky_image;                 ///< its file, empty without one
    std::uint64_t emissive_triangles = 0;  ///< with instances
    std::size_t moving_objects = 0;
    glm::dvec3 box_low_m{0}, box_high_m{0};  ///< at time 0

    double path_length_m = 0, path_duration_s = 0;
    double turn_deg = 0;            ///< sum of the angles the gaze turns through
    double fastest_turn_deg_s = 0;  ///< of the gaze, from one key to the next
    double nearest_m = 0,
           nearest_time_s = 0;  ///< closest triangle (its mask ignored) to the head, sampled along the path
    double head_radius_m = 0;
    double box_radius_m = 0;  ///< B of bound.h for a sphere at the head's centre and the default IPD
    double sphere_width = 0;  ///< columns that match the centre of a view with the default focal length
    /// What a window must cover for such a view of 16:9, 90 degrees wide, whose gaze the server knows window_delay_s
    /// late.
    double window_width_deg = 0, window_height_deg = 0;
    /// Depth codes if the whole default budget went to them: w at nearest_m in steps of twice the budget; infinite
    /// where the nearest triangle is in the head box.
    double depth_levels = 0;
};

SceneSummary summarise(const SceneModel& model, const SceneDescription& scene);

std::string summary_text(const SceneSummary& summary);
nlohmann::ordered_json summary_json(const SceneSummary& summary);

// Which nodes a scene's model has and where its instances stand, as JSON: what a renderer in another process needs to
// move objects and to number surfaces as ours does.

/// {"objects": [{"name", "parent", "world_from_object"}], "instances": [{"object", "material", "world_from_object"}]};
/// matrices are 16 numbers, column by column.
std::string placements_json(const SceneModel& model);

}  // namespace equistream
