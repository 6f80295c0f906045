#pragma once
/// Where the client's depth comes from. One interface for local ray casts, streamed depth, exact AOVs and rasters.
#include <equistream/camera.h>
#include <equistream/image.h>
#include <equistream/patches.h>

#include <glm/glm.hpp>

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace equistream {

class DepthSource {
public:
    virtual ~DepthSource() = default;
    virtual std::string_view name() const = 0;
    /// The scene's state for the casts that follow. Not while cast runs.
    virtual void set_time(double time_s) = 0;
    /// Fills `depth_m` (1 channel, the camera's size) with the Euclidean distance in metres from the camera's centre
    /// to the nearest surface along each pixel-centre ray; +inf for a miss, NaN where the source knows nothing. Throws
    /// WorkError where it cannot.
    virtual void cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) = 0;
    /// The same of an atlas of patches (patches.h) whose sphere has this pose, for streams that carry no depth of it.
    /// `depth_m` has the atlas' size; unused slots get +inf. Returns false, and leaves `depth_m` alone, where the
    /// source knows no geometry. The atlas must be sound (patch_atlas_problem).
    virtual bool cast_patches(const PatchAtlas&, const Pose&, ImageView<float> /*depth_m*/) { return false; }
};

/// Depth planes that came from elsewhere (the renderer's AOV), handed out to whoever asks for that very view. Any other
/// view goes to `otherwise`, if there is one, else is a WorkError.
class ExactDepth : public DepthSource {
public:
    explicit ExactDepth(std::unique_ptr<DepthSource> otherwise = nullptr);

    std::string_view name() const override { return "exact"; }
    /// Forgets all planes.
    void set_time(double time_s) override;
    /// The plane is borrowed until set_time.
    void add(const Camera& camera, const Pose& pose, ImageView<const float> depth_m);
    /// Whether cast would succeed without `otherwise`.
    bool holds(const Camera& camera, const Pose& pose) const { return find(camera, pose) != nullptr; }
    void cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) override;
    bool cast_patches(const PatchAtlas& atlas, const Pose& pose, ImageView<float> depth_m) override;

private:
    struct Plane {
        Camera camera;
        Pose pose;
        ImageView<const float> depth_m;
    };
    const Plane* find(const Camera& camera, const Pose& pose) const;

    std::vector<Plane> planes_;
    std::unique_ptr<DepthSource> otherwise_;
};

/// The same with planes that came in the stream's own depth tracks: of the source's view, and of no eye's.
class StreamDepth : public ExactDepth {
public:
    using ExactDepth::ExactDepth;

    std::string_view name() const override { return "stream"; }
};

// What a client that has the scene's geometry knows of a surface's colour: where a ray hits, and the surface's base
// colour there, unlit. One interface, so that the fill chain needs no ray tracer.

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
