#pragma once
/// The geometry a client needs of a scene, under the bound (bound.h): simplified by distance to the head boxes along
/// the camera path, without what no eye in them can see, and checked by casting rays. Built once per scene
/// (equistream_client_model); what comes out is a SceneModel for depth only: positions, triangles, alpha masks.
#include <scenes/library/model.h>
#include <scenes/library/scene.h>

#include <array>
#include <functional>
#include <string>

namespace equistream {

struct ClientModelOptions {
    double error_rad = 0;       ///< what an eye may see displaced by geometry; above 0
    double silhouette_rad = 0;  ///< by how much edges may move; at least error_rad
    double ipd_m = default_ipd_m;
    std::int64_t visibility_rays = std::int64_t{1} << 26;  ///< to find out what can be seen
    std::int64_t check_rays = std::int64_t{1} << 21;       ///< per round of checking
    double kept_quantile = 0.9999;                         ///< of the checked rays, that keep the bound
    int rounds = 12;                                       ///< of checking and restoring, at most
    std::uint64_t seed = 1;
};

/// What random rays from random eyes in the boxes found, the model against the scene.
struct RayCheck {
    std::int64_t rays = 0;
    std::int64_t within = 0;    ///< displaced by no more than error_rad
    std::int64_t at_edges = 0;  ///< beyond that, but the scene shows the same at most silhouette_rad away
    std::int64_t failing = 0;   ///< neither
    /// Displacement of rays, and shift of edges (of the rays at edges, an upper bound): median, 99 %, 99.9 %, 99.99 %.
    std::array<double, 4> displacement_rad{};
    std::array<double, 4> edge_shift_rad{};

    double kept() const { return rays == 0 ? 1 : 1 - double(failing) / double(rays); }
};

struct ClientModelFigures {
    std::uint64_t triangles_before = 0, triangles_seen = 0, triangles_after = 0;  ///< with instances
    std::uint64_t unique_before = 0, unique_after = 0;                            ///< without
    double box_radius_m = 0;
    std::uint64_t centres = 0;       ///< that stand for the path
    double cell_m = 0, added_m = 0;  ///< as HeadBoxes has them
    int rounds = 0;                  ///< of checking
    bool holds = false;              ///< the last check kept the quantile
    RayCheck check;                  ///< the last one, by rays that no restoring was done for
    double visibility_s = 0, simplify_s = 0, check_s = 0;
};

struct ClientModel {
    SceneModel model;
    ClientModelFigures figures;
};

/// `model` is the scene's, without shading data. `told` is called before each step with what it is. Throws InputError
/// for options out of range and a scene whose path has no point. The same input and seed give the same model.
ClientModel build_client_model(const SceneModel& model, const SceneDescription& scene,
                               const ClientModelOptions& options,
                               const std::function<void(const std::string&)>& told = {});

/// The description that goes with the model: the scene's path, head box and moving objects, and whose geometry it
/// stands for (SceneDescription::stands_for). Writes FILE.json and FILE.glb beside it; throws WorkError naming them.
void write_client_model(const std::filesystem::path& json_file, const ClientModel& model,
                        const SceneDescription& scene);
/// What lies beside the geometry until its description does: a run that is killed in between can be repeated. A file of
/// this name that is there is written in place, so that a lock on it holds.
std::filesystem::path unfinished_description(std::filesystem::path json_file);

// An alpha mask as a texture that write_glb embeds.

/// A PNG of grey and alpha, as a reader of the model decodes it back to the same mask.
Texture mask_texture(const AlphaMask& mask, const std::string& name);

}  // namespace equistream
