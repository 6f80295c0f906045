#pragma once
/// The client's geometry with its base colours, by casting rays with Embree (equistream_client_ray). It is loaded when
/// the first ray is cast, or before that in the background; a texture is decoded when a ray first meets it.
#include "depth_source.h"

#include <scenes/library/scene.h>

#include <memory>

namespace equistream {

class RayColour : public GeometryColour {
public:
    explicit RayColour(const SceneDescription& scene);
    ~RayColour() override;

    /// Begins to load the geometry on a thread of its own and returns at once; what fails is thrown by the first cast.
    /// Once, and before any cast.
    void start_loading();

    void set_time(double time_s) override;
    /// Throws InputError as load_model does, the first time. Calls of several threads take turns.
    void cast(std::span<const GeometryRay> rays, std::span<GeometryHit> hits) override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
