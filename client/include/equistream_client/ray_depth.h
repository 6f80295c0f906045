#pragma once
/// Depth by casting rays into the scene's own geometry with Embree (equistream_client_ray). Alpha masks are respected
/// and moving objects are where they are at the time that was set.
#include <equistream/bound.h>
#include <equistream_client/depth_source.h>
#include <equistream_scene/scene.h>

#include <memory>

namespace equistream {

struct RayDepthOptions {
    /// Spheres are carried from the nearest one cast before (same camera and orientation): a pixel whose triangle's
    /// plane is known is met by its new ray again, exactly; where the planes around it do not agree within `error_rad`
    /// by the bound (bound.h), at depth edges, in what they uncover, on moving objects, next to poles that see several
    /// planes and in every 64th square of pixels rays are cast. Edges may be off by a pixel.
    bool reuse = false;
    /// Of the head box that sizes the error; 0: the scene's around the head's centre, for eyes default_ipd_m apart.
    double box_radius_m = 0;
    double error_rad = default_budget_share * error_budget_rad(default_focal_length_px);
};

class RayDepth : public DepthSource {
public:
    /// Loads the scene's model without shading data and builds the BVH; throws InputError as load_model does.
    explicit RayDepth(const SceneDescription& scene, const RayDepthOptions& options = {});
    ~RayDepth() override;

    std::string_view name() const override { return "ray"; }
    void set_time(double time_s) override;
    void cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) override;
    bool cast_patches(const PatchAtlas& atlas, const Pose& pose, ImageView<float> depth_m) override;

    /// As if nothing had been cast since the last set_time, so that the same can be timed once more: what those casts
    /// left to be carried on is forgotten. Nothing else depends on it.
    void take_back();
    /// The same for everything that was ever cast.
    void forget();

    std::uint64_t triangle_count() const;
    std::size_t memory_bytes() const;  ///< held by Embree

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
