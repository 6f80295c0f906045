#pragma once
/// The client's geometry with its base colours, by casting rays with Embree (equistream_client_ray). It is loaded, with
/// textures, when the first ray is cast: a run whose other rungs fill every gap never pays for it.
#include <equistream_client/geometry_colour.h>
#include <equistream_scene/scene.h>

#include <memory>

namespace equistream {

class RayColour : public GeometryColour {
public:
    explicit RayColour(const SceneDescription& scene);
    ~RayColour() override;

    void set_time(double time_s) override;
    /// Throws InputError as load_model does, the first time. Calls of several threads take turns.
    void cast(std::span<const GeometryRay> rays, std::span<GeometryHit> hits) override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
