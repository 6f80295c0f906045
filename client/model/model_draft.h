#pragma once
/// A client's model in the making: what is kept of each instance, and how strictly.
#include "ray_checks.h"
#include "simplify.h"

#include <vector>

namespace equistream {

/// What becomes of an instance of the scene.
enum class Part {
    merged,  ///< placed once, unmoving, no mask: part of one welded mesh in world space
    placed,  ///< its mesh is shared: it keeps its placement, and takes that version of the mesh which suffices for it
    exact,   ///< alpha-masked or moving: triangles stay as they are
};

class ModelDraft {
public:
    /// All are borrowed and outlive the draft.
    ModelDraft(const SceneModel& scene, const SceneDescription& description, const HeadBoxes& boxes, double error_rad);

    /// Takes what can be seen; movers are kept whole.
    void keep(SeenTriangles seen);
    /// The model as things are.
    SceneModel build();
    /// Makes what rays failed on stricter: triangles that were dropped come back, others may move less.
    void restore(const std::vector<FailedRay>& failed);

    std::uint64_t kept_triangles() const;  ///< before they are simplified

private:
    void restore_scene_side(const HitId& hit);
    void restore_model_side(const HitId& hit);
    void build_merged(SceneModel& out);
    void build_placed(SceneModel& out);
    void build_exact(SceneModel& out);
    void place(SceneModel& out, std::uint32_t mesh, std::uint32_t instance);
    void copy_moving_objects(SceneModel& out);
    std::uint32_t material_of(SceneModel& out, const Mesh& mesh);
    std::vector<glm::uvec3> kept_of_mesh(const std::vector<std::uint32_t>& instances) const;
    /// The power of 4 of the model's unit that any kept triangle of an instance may move by, in the mesh's own space.
    int allowed_log4(std::uint32_t instance) const;

    const SceneModel& scene_;
    const SceneDescription& description_;
    const HeadBoxes& boxes_;
    double error_rad_;
    std::vector<Part> part_;    ///< by instance of the scene
    std::vector<bool> moving_;  ///< by instance of the scene
    SeenTriangles kept_;
    std::vector<std::uint8_t> strictness_;   ///< of placed instances
    StaticGeometry merged_;                  ///< triangles: those kept
    std::vector<std::size_t> first_vertex_;  ///< by instance: where its vertices' points are in points_
    std::vector<std::uint32_t> points_;      ///< vertex of merged instances to vertex of merged_
    // Of the model built last:
    std::vector<std::uint32_t> source_instance_;  ///< by instance of the model; no_index: merged
    std::vector<glm::uvec3> merged_triangles_;    ///< of the model, in vertices of merged_
    std::vector<std::uint32_t> new_material_;     ///< by material of the scene
    std::vector<std::uint32_t> new_object_;       ///< by object of the scene; no_index: not kept
};

}  // namespace equistream
