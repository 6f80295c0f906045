#include "rays.h"

#include "sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream {

FrameRays::FrameRays(const FrameInfo& info)
    : camera_(info.camera), atlas_(info.patches), width_(picture_width(info)),
      world_from_camera_(glm::mat3_cast(info.camera_pose.orientation)), key_(frame_key(info.seed, info.index)) {
    if (info.window_columns > 0) {
        const WindowGrid grid = window_grid_of(info);
        const WindowPlace place = window_place(grid, std::get<EquirectCamera>(info.camera).range).value();
        corner_ = {place.x, place.y};
        camera_ = EquirectCamera{grid.columns, grid.rows, {}};
        width_ = grid.columns;
    }
    const Pose& pose = info.camera_pose;
    if (!atlas_)
        origins_.emplace_back(pose.position_m);
    else
        for (const glm::dvec3& offset : atlas_->offsets_m)
            origins_.emplace_back(pose.position_m + pose.orientation * offset);
}

FrameRays::Place FrameRays::place_of(int x, int y, double u, double v) const {
    if (!atlas_)
        return {x, y, u, v};
    const PixelCoordinates<double> at = patch_sphere_pixel(*atlas_, x, y, u, v);
    return {x, y, at.u, at.v};
}

es_ray FrameRays::geometry(int x, int y) const {
    const glm::ivec2 at = on_sphere(x, y);
    const Place place = place_of(at.x, at.y, at.x + 0.5, at.y + 0.5);
    return ray(glm::vec3(direction_of(camera_, place.u, place.v)), place, geometry_sample);
}

es_ray FrameRays::colour(int x, int y, std::uint32_t sample) const {
    const glm::ivec2 at = on_sphere(x, y);
    const SubpixelOffset offset = subpixel_offset(key_, pixel_of(at.x, at.y), sample);
    const Place place = place_of(at.x, at.y, static_cast<float>(at.x) + offset.u, static_cast<float>(at.y) + offset.v);
    return ray(direction_float(static_cast<float>(place.u), static_cast<float>(place.v)), place, sample);
}

/// Single precision is a few ten-thousandths of a pixel here, and several times as fast; geometry rays are exact.
glm::vec3 FrameRays::direction_float(float u, float v) const {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera_)) {
        const auto d = equirect_direction<float>({u, v}, sphere->width, sphere->height, sphere->range);
        return {d.x, d.y, d.z};
    }
    const auto& view = std::get<PerspectiveCamera>(camera_);
    const auto d = perspective_direction<float>({u, v}, view.width, view.height, view.fov_x_rad);
    return glm::normalize(glm::vec3(d.x, d.y, d.z));
}

/// The side of a square with the pixel's solid angle.
float FrameRays::footprint_rad(const glm::vec3& d) const {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera_)) {
        const double columns = sphere->range.longitude_span() / sphere->width;
        const double rows = sphere->range.latitude_span() / sphere->height;
        // A polar pixel is a triangle: half a row from the pole is as narrow as it gets.
        const double cosine = std::max<double>(std::sqrt(std::max(0.0f, 1 - d.y * d.y)), 0.5 * rows);
        return static_cast<float>(std::sqrt(columns * rows * cosine));
    }
    const double cosine = -d.z;
    return static_cast<float>(std::sqrt(cosine * cosine * cosine) / std::get<PerspectiveCamera>(camera_).focal_px());
}

glm::vec3 FrameRays::origin(const Place& place) const {
    if (atlas_)
        return origins_[atlas_->slot_at(place.x, place.y).offset_index];
    if (!is_ods(camera_))
        return origins_.front();
    return origins_.front() +
           world_from_camera_ * glm::vec3(std::get<EquirectCamera>(camera_).origin(place.u, place.v));
}

es_ray FrameRays::ray(const glm::vec3& direction_camera, const Place& place, std::uint32_t sample) const {
    const glm::vec3 d = glm::normalize(world_from_camera_ * direction_camera);
    const glm::vec3 from = origin(place);
    es_ray ray{};
    ray.origin[0] = from.x;
    ray.origin[1] = from.y;
    ray.origin[2] = from.z;
    ray.t_min = 0;
    ray.direction[0] = d.x;
    ray.direction[1] = d.y;
    ray.direction[2] = d.z;
    ray.t_max = std::numeric_limits<float>::infinity();
    ray.seed = ray_seed(key_, pixel_of(place.x, place.y), sample);
    ray.footprint_rad = footprint_rad(direction_camera);
    return ray;
}

}  // namespace equistream
