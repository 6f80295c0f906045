#pragma once
/// Depth drawn by OpenGL 4.5 from the scene's own geometry, without a window (equistream_client_gl). Alpha masks are
/// respected and moving objects are where they are at the time that was set. Needs GL_ARB_shader_viewport_layer_array
/// and GL_ARB_indirect_parameters. Surfaces within 1 cm of planar distance are not seen: 1 cm ahead of a view, up to
/// 2.1 cm at the border of a sphere's views and 2.8 cm in their corners. Casts of one object wait for each other,
/// whatever thread they come from; the context that is current in theirs is so again afterwards. Patches get no depth.
#include <client/depth/depth_source.h>
#include <equistream/bound.h>
#include <scenes/library/scene.h>

#include <memory>
#include <string>

namespace equistream {

struct GlDepthOptions {
    /// As the paper has it: six faces of a cube for every sphere, turned equirectangular. Else spheres get the depth of
    /// those samples that eyes may look up whose depth was cast since the time was set, and of the sixteen around each,
    /// as long as no surface lies within half a metre of the sphere's centre; NaN elsewhere. All samples where no eye's
    /// depth was cast, or that of more than four views.
    bool cube = false;
    /// Of the head box that sizes the error; 0: the scene's around the head's centre, for eyes default_ipd_m apart.
    double box_radius_m = 0;
    /// A sphere's depth is interpolated where that is within this error by the bound (bound.h).
    double error_rad = default_budget_share * error_budget_rad(default_focal_length_px);
};

/// What the last cast drew.
struct GlDepthFigures {
    int views = 0;
    std::uint64_t triangles = 0;  ///< of all views together
};

class GlDepth : public DepthSource {
public:
    /// Loads the scene's model without shading data; throws InputError as load_model does, and where there is no such
    /// OpenGL, and WorkError where the scene is beyond its limits.
    explicit GlDepth(const SceneDescription& scene, const GlDepthOptions& options = {});
    ~GlDepth() override;

    std::string_view name() const override;
    void set_time(double time_s) override;
    void cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) override;

    std::string driver() const;  ///< the renderer's name
    GlDepthFigures figures() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
