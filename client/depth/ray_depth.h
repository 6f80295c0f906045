#pragma once
/// Depth by casting rays into the scene's own geometry with Embree (equistream_client_ray). Alpha masks are respected
/// and moving objects are where they are at the time that was set.
#include "depth_source.h"

#include <scenes/library/scene.h>

#include <memory>

namespace equistream {

class RayDepth : public DepthSource {
public:
    /// Loads the scene's model without shading data and builds the BVH; throws InputError as load_model does.
    explicit RayDepth(const SceneDescription& scene);
    ~RayDepth() override;

    std::string_view name() const override { return "ray"; }
    void set_time(double time_s) override;
    void cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) override;
    bool cast_patches(const PatchAtlas& atlas, const Pose& pose, ImageView<float> depth_m) override;

    std::uint64_t triangle_count() const;
    std::size_t memory_bytes() const;  ///< held by Embree

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
