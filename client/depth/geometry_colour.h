#pragma once
/// What a client that has the scene's geometry knows of a surface's colour: where a ray hits, and the surface's base
/// colour there, unlit. One interface, so that the fill chain needs no ray tracer.
#include <glm/glm.hpp>

#include <cstdint>
#include <limits>
#include <span>

namespace equistream {

struct GeometryRay {
    glm::vec3 origin_m{0};   ///< world
    glm::vec3 direction{0};  ///< world, unit
    float spread_rad = 0;    ///< angle between this ray and those of the pixels around
};

struct GeometryHit {
    float distance_m = std::numeric_limits<float>::infinity();  ///< +inf for a miss; all else is then without meaning
    glm::vec3 base_colour{0};                                   ///< linear Rec.709
    glm::vec3 normal{0};                                        ///< world, unit, towards the ray's origin
    std::uint32_t instance = 0;                                 ///< which placement of which mesh
    bool matte = true;  ///< false: it shines by itself, mirrors or is glass, so that its base colour says little
};

class GeometryColour {
public:
    virtual ~GeometryColour() = default;
    /// The scene's state for the casts that follow. Not while cast runs.
    virtual void set_time(double time_s) = 0;
    /// hits[i] is what rays[i] hits first. Both have the same length.
    virtual void cast(std::span<const GeometryRay> rays, std::span<GeometryHit> hits) = 0;
};

}  // namespace equistream
