#include "viewpoint.h"

#include <equistream/conventions.h>

#include <scenes/embree/embree_rays.h>

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

namespace equistream {
namespace {

constexpr std::size_t direction_count = 256;
constexpr int columns = 16;             // of places to try, along x and along z
constexpr int max_surfaces = 32;        // below each other, in a column
constexpr double min_distance_m = 0.3;  // to the nearest surface, in any direction
constexpr double same_storey_m = 0.25;  // by which heights of one storey differ at most
constexpr double level_sine = 0.25;     // of directions that count as level
constexpr int headings = 64;
constexpr double infinity = std::numeric_limits<double>::infinity();

const glm::dvec3 up(0, 1, 0);

using Directions = std::array<glm::dvec3, direction_count>;

/// Evenly over the sphere: heights in equal steps, each a golden turn on.
Directions even_directions() {
    Directions directions;
    for (std::size_t i = 0; i < direction_count; ++i) {
        const auto step = static_cast<double>(i);
        const double y = 1 - (2 * step + 1) / static_cast<double>(direction_count);
        const double across = std::sqrt(1 - y * y), turn = 2 * pi * (std::numbers::phi - 1) * step;
        directions[i] = {across * std::cos(turn), y, across * std::sin(turn)};
    }
    return directions;
}

struct Place {
    glm::dvec3 position_m{0};
    std::array<double, direction_count> distances_m{};  ///< by direction; infinite where nothing is met
    std::size_t hits = 0, hits_from_behind = 0;

    double nearest_m() const { return *std::ranges::min_element(distances_m); }
    bool is_among_surfaces() const {
        return 2 * hits > direction_count && 2 * hits_from_behind < hits && nearest_m() >= min_distance_m;
    }
};

class Survey {
public:
    Survey(const SceneModel& model, const WorldBox& bounds)
        : model_(model), bounds_(bounds), bvh_(model), directions_(even_directions()) {
        trace_thread_init();
    }

    std::optional<Viewpoint> inside() const {
        const std::vector<Place> places = places_among_surfaces();
        if (places.empty())
            return std::nullopt;
        const Place& best = best_of(places);
        return Viewpoint{{best.position_m, heading(best)}, true, best.hits == direction_count};
    }

private:
    struct Met {
        double distance_m = infinity;
        bool from_behind = false;
    };

    Met look(const glm::dvec3& from, const glm::dvec3& direction) const {
        RTCRayHit ray = embree_ray_hit(glm::vec3(from), glm::vec3(direction));
        bvh_.intersect1(ray);
        const HitId id = bvh_.resolve(ray.hit);
        if (id.instance == no_index)
            return {};
        return {static_cast<double>(ray.ray.tfar), is_from_behind(id, direction)};
    }

    /// By how the triangle is wound, whatever its material says: exporters call nearly everything double-sided.
    bool is_from_behind(const HitId& id, const glm::dvec3& direction) const {
        const Instance& instance = model_.instances[id.instance];
        const Mesh& mesh = model_.meshes[instance.mesh];
        const glm::dmat3 transform(glm::dmat4(instance.world_from_object));
        const glm::uvec3& t = mesh.triangles[id.triangle];
        const auto corner = [&](unsigned index) { return transform * glm::dvec3(mesh.positions[index]); };
        const glm::dvec3 normal = glm::cross(corner(t.y) - corner(t.x), corner(t.z) - corner(t.x));
        const bool is_mirrored = glm::determinant(transform) < 0;
        return (glm::dot(normal, direction) > 0) != is_mirrored;
    }

    Place place_at(const glm::dvec3& position) const {
        Place place{position};
        for (std::size_t i = 0; i < direction_count; ++i) {
            const Met met = look(position, directions_[i]);
            place.distances_m[i] = met.distance_m;
            place.hits += std::isfinite(met.distance_m);
            place.hits_from_behind += met.from_behind;
        }
        return place;
    }

    /// Where eyes are above the surfaces that a plumb line meets, if nothing lies between.
    std::vector<double> eye_heights(double x, double z) const {
        const double step_m = 1e-3 + 1e-5 * (bounds_.high.y - bounds_.low.y);
        std::vector<double> heights;
        double above = bounds_.high.y;
        for (int i = 0; i < max_surfaces; ++i) {
            const double from = i == 0 ? above + step_m : above - step_m;
            const Met met = look({x, from, z}, -up);
            if (!std::isfinite(met.distance_m))
                break;
            const double surface = from - met.distance_m;
            if (surface + eye_height_m <= above)
                heights.push_back(surface + eye_height_m);
            above = surface;
        }
        return heights;
    }

    std::vector<Place> places_among_surfaces() const {
        std::vector<Place> places;
        const glm::dvec3 cell = (bounds_.high - bounds_.low) / static_cast<double>(columns);
        for (int i = 0; i < columns; ++i)
            for (int k = 0; k < columns; ++k) {
                const double x = bounds_.low.x + cell.x * (i + 0.5), z = bounds_.low.z + cell.z * (k + 0.5);
                for (const double y : eye_heights(x, z))
                    if (Place place = place_at({x, y, z}); place.is_among_surfaces())
                        places.push_back(std::move(place));
            }
        return places;
    }

    const Place& best_of(const std::vector<Place>& places) const {
        const auto share_storey = [](const Place& a, const Place& b) {
            return std::abs(a.position_m.y - b.position_m.y) <= same_storey_m;
        };
        const auto on_its_storey = [&](const Place& a) {
            return std::ranges::count_if(places, [&](const Place& b) { return share_storey(a, b); });
        };
        const Place& usual = *std::ranges::max_element(places, {}, on_its_storey);
        // To the centimetre: where only the floor or the ceiling is near, the middle is best.
        const glm::dvec3 middle = 0.5 * (bounds_.low + bounds_.high);
        const auto merit = [&](const Place& place) {
            return std::pair(share_storey(place, usual) ? std::round(100 * level_distance_m(place)) : -1,
                             -glm::length(place.position_m - middle));
        };
        return *std::ranges::max_element(places, {}, merit);
    }

    double level_distance_m(const Place& place) const {
        double nearest_m = infinity;
        for (std::size_t i = 0; i < direction_count; ++i)
            if (std::abs(directions_[i].y) < level_sine)
                nearest_m = std::min(nearest_m, place.distances_m[i]);
        return nearest_m;
    }

    /// Whose 90 degrees meet surfaces farthest away in all; what is open counts nothing.
    glm::dquat heading(const Place& place) const {
        const double cosine = std::sqrt(0.5);
        glm::dquat best(1, 0, 0, 0);
        double max_m = 0;
        for (int k = 0; k < headings; ++k) {
            const glm::dquat turned = glm::angleAxis(2 * pi * k / headings, up);
            const glm::dvec3 ahead = turned * glm::dvec3(0, 0, -1);
            double sum_m = 0;
            for (std::size_t i = 0; i < direction_count; ++i)
                if (glm::dot(directions_[i], ahead) > cosine && std::isfinite(place.distances_m[i]))
                    sum_m += place.distances_m[i];
            if (sum_m > max_m) {
                max_m = sum_m;
                best = turned;
            }
        }
        return best;
    }

    const SceneModel& model_;
    WorldBox bounds_;
    Bvh bvh_;
    Directions directions_;
};

/// The ball around the bounds spans 60 degrees, or less where that would be nearer than an arm's length.
Viewpoint in_front_of(const WorldBox& bounds) {
    constexpr double arm_m = 0.5;
    const glm::dvec3 middle = 0.5 * (bounds.low + bounds.high);
    const double radius_m = 0.5 * glm::length(bounds.high - bounds.low);
    const double away_m = std::max(2 * radius_m, radius_m + arm_m);
    // From a little above, as things on a table are looked at; of large ones from where people stand.
    const double height = std::min(middle.y + away_m / 3, bounds.low.y + eye_height_m);
    const glm::dvec3 position(middle.x, height, middle.z + away_m);
    return Viewpoint{{position, glm::quatLookAtRH(glm::normalize(middle - position), up)}};
}

}  // namespace

Viewpoint find_viewpoint(const SceneModel& model, const WorldBox& bounds) {
    return Survey(model, bounds).inside().value_or(in_front_of(bounds));
}

}  // namespace equistream
