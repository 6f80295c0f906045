#pragma once
/// Writes a scene as Mitsuba 3 XML with a folder of PLY meshes and images beside it. docs/scenes.md has the table of
/// what becomes what, and where Mitsuba's plugins mean something else than our tracer.
///
/// Names in the XML: shapes instance-K (K: index in SceneModel::instances; instance-K-back is the other side of one
/// that emits on both), shape groups mesh-K, materials material-K, the sun's disc sun. Meshes placed once that stand
/// still, and all that emit, are written in world space; the others once, with instances of them. Baked, all placements
/// of one material that stand still are a single mesh merged-K, whose attribute face_instance is each triangle's K.
#include <scenes/library/scene.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace equistream {

enum class MitsubaCamera { perspective, equirect };

struct MitsubaSettings {
    MitsubaCamera camera = MitsubaCamera::perspective;
    int width = 0, height = 0;   ///< pixels; 0: 1280x720 in perspective, 2048x1024 as a sphere
    int samples_per_pixel = 64;  ///< at least 1
    std::int64_t frame = 0;      ///< whose pose and transforms are written; at least 0
    /// Writes all that stands still in world space, one mesh a material. More to store, but Mitsuba's vectorised
    /// variants take many seconds a render for a thousand shapes, and minutes for a thousand instances.
    bool bake = false;
    bool overwrite = false;  ///< replaces what an earlier conversion wrote
};

struct MitsubaReport {
    std::uint64_t triangles = 0;  ///< with instances
    std::size_t shapes = 0, instances = 0, groups = 0, images = 0;
    std::uint64_t bytes = 0;         ///< of the folder
    std::vector<std::string> notes;  ///< what does not mean the same there; one line each
};

/// Writes `file` and the folder beside it, NAME.files for NAME.xml: the folder first, each under its name only when it
/// is whole. Throws InputError where something is in the way, WorkError naming the file that could not be written.
/// Holds one image and one mesh per thread besides the model.
MitsubaReport write_mitsuba_scene(const SceneModel& model, const SceneDescription& scene,
                                  const std::filesystem::path& file, const MitsubaSettings& settings = {});

}  // namespace equistream
