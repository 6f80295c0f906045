#include "surfaces.h"

#include <equistream/virtual_image.h>

#include <limits>

namespace equistream::embree_host {
namespace {

using Vector = Vector3<double>;

Vector from_glm(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}

glm::vec3 to_glm(const Vector& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Straight on, mirrored, or nothing: the path ends on this surface.
BsdfSample::Kind sharp_lobe(Worker& worker, const ShadingScene& scene, const ShadingPoint& point,
                            const glm::vec3& direction, float footprint_m) {
    const SurfaceParameters parameters =
        surface_parameters(scene.material(point.material), point, footprint_m, glm::vec3(0.5f), worker.textures());
    return Bsdf(parameters, glm::dot(point.normal, -direction)).sharp_lobe();
}

class SharpPath {
public:
    SharpPath(Worker& worker, const SurfacesScene& scene, const es_ray& ray)
        : worker_(worker), scene_(scene), origin_(to_vec3(ray.origin)), spread_rad_(ray.footprint_rad),
          eye_(from_glm(origin_)), eye_direction_(from_glm(to_vec3(ray.direction))),
          pencil_(Pencil<double>::from_eye(eye_direction_)) {}

    void follow(Worker::Hit hit, es_surface& surface) {
        for (unsigned surfaces = 0; hit.id.instance != no_index; ++surfaces) {
            const ShadingPoint point =
                scene_.shading.surface_at(hit.id, origin_, to_glm(pencil_.direction), hit.distance);
            pencil_.travel(double{lead_m_} + hit.distance);
            length_m_ += hit.distance;
            if (surfaces == max_sharp_surfaces || !leave(point, hit)) {
                end_on(point, hit, surface);
                return;
            }
            lead_m_ = glm::dot(origin_ - point.position, to_glm(pencil_.direction));
            hit = worker_.trace(origin_, to_glm(pencil_.direction));
        }
        put(pencil_.image_distance(true), {}, {}, surface);
    }

private:
    /// Where the ray goes on, if it does.
    bool leave(const ShadingPoint& point, const Worker::Hit& hit) {
        const glm::vec3 direction = to_glm(pencil_.direction);
        const auto lobe = sharp_lobe(worker_, scene_.shading, point, direction, length_m_ * spread_rad_);
        if (lobe == BsdfSample::Kind::straight)
            origin_ = offset_origin(point.position, -point.geometric_normal, point.reach);
        if (lobe != BsdfSample::Kind::mirror)
            return lobe == BsdfSample::Kind::straight;
        const glm::vec3 mirrored = glm::reflect(direction, point.normal);
        if (glm::dot(mirrored, point.geometric_normal) <= 0)
            return false;
        pencil_.onto_surface(from_glm(point.geometric_normal));
        Vector bend[Pencil<double>::count];
        for (int i = 0; i < Pencil<double>::count; ++i)
            bend[i] = from_glm(scene_.shading.normal_change(hit.id, point, to_glm(pencil_.position[i])));
        pencil_.reflect(from_glm(point.normal), bend);
        origin_ = offset_origin(point.position, point.geometric_normal, point.reach);
        return true;
    }

    void end_on(const ShadingPoint& point, const Worker::Hit& hit, es_surface& surface) const {
        const NeighbourPoints moved = neighbour_points(scene_, hit.id, point.position);
        put(pencil_.image_distance(false), from_glm(moved.previous - point.position),
            from_glm(moved.next - point.position), surface);
    }

    void put(double distance_m, const Vector& to_previous, const Vector& to_next, es_surface& surface) const {
        surface.virtual_distance_m = static_cast<float>(distance_m);
        const Vector image = sum(eye_, distance_m, eye_direction_);
        if (!(distance_m < std::numeric_limits<float>::max()))
            return;
        const auto moved = [&](const Vector& by) {
            return to_glm(sum(image, 1.0, pencil_.image_movement(eye_direction_, distance_m, by)));
        };
        store(moved(to_previous), surface.virtual_previous_m);
        store(moved(to_next), surface.virtual_next_m);
    }

    Worker& worker_;
    const SurfacesScene& scene_;
    glm::vec3 origin_;
    float spread_rad_, length_m_ = 0;
    float lead_m_ = 0;  // from the surface left to where the ray begins, off it
    const Vector eye_, eye_direction_;
    Pencil<double> pencil_;
};

}  // namespace

void follow_sharp_path(Worker& worker, const SurfacesScene& scene, const es_ray& ray, const Worker::Hit& hit,
                       es_surface& surface) {
    SharpPath(worker, scene, ray).follow(hit, surface);
}

}  // namespace equistream::embree_host
