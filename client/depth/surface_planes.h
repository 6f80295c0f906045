#pragma once
/// The plane of every placed triangle that does not move, in the world: what a pixel of known surface is intersected
/// with again, wherever the eye is. Triangles of one plane share it, as near as single precision holds their corners.
/// Internal to depth reuse.
#include <equistream_scene/bvh.h>
#include <equistream_scene/model.h>

#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

class SurfacePlanes {
public:
    /// What has no plane here (movers, what is beyond the table's size) and has to be cast; and where nothing is hit.
    static constexpr std::int32_t none = 0, sky = 1;

    /// Reads `model` once; keeps nothing of it.
    SurfacePlanes(const SceneModel& model, std::span<const std::uint32_t> movers);

    /// Of a hit, or of a miss.
    std::int32_t of(const HitId& hit) const {
        if (hit.instance == no_index)
            return sky;
        const std::size_t first = first_[hit.instance];
        return first == no_planes ? none : planes_[first + hit.triangle];
    }
    /// Normal and distance from the world's origin along it, four floats a plane; `sky` is at infinity.
    const float* values() const { return values_.data(); }

private:
    static constexpr std::size_t no_planes = ~std::size_t{0};

    void add(const Mesh& mesh, const glm::dmat4& world_from_object);

    std::vector<std::size_t> first_;    ///< by instance: of its triangles in planes_, or no_planes
    std::vector<std::int32_t> planes_;  ///< by placed triangle
    std::vector<float> values_;
};

}  // namespace equistream
