#pragma once
/// Meshes and their placements as Mitsuba shapes.
#include "asset_folder.h"
#include "convert.h"
#include "lights.h"

namespace equistream::mitsuba_xml {

class Shapes {
public:
    /// `transforms` of all instances, `moving` those that other frames have elsewhere; `bake`: no instances of what
    /// stands still, one mesh of each material instead. All borrowed.
    Shapes(const SceneModel& model, const std::vector<glm::mat4>& transforms, const std::vector<std::uint32_t>& moving,
           Materials& materials, bool bake);

    Bounds bounds() const;
    void ask_for_images(Images& images) const;
    void write_meshes(AssetFolder& folder) const;
    void declare(pugi::xml_node scene, const AssetFolder& folder, Images& images);
    void report(MitsubaReport& to) const;
    /// Whether light samples, were there only shapes, would have nowhere to go. Once declared.
    bool only_unsampled_lights() const { return unsampled_glows_ > 0 && sampled_glows_ == 0; }

private:
    enum class Form { baked, merged, glowing, instance };
    struct Glow {
        std::string image;  ///< of its emission; empty: constant
        double share = 0;   ///< of the light samples
        bool both_sides = false;
    };

    void merge();
    PlyPart part_of(std::uint32_t instance) const;
    double power_of(std::uint32_t instance) const;
    const Mesh& mesh_of(std::uint32_t instance) const { return model_.meshes[model_.instances[instance].mesh]; }
    std::string emission_image(const Mesh& mesh, Images& images) const;
    void write_glowing(AssetFolder& folder, std::uint32_t instance) const;
    void declare_glowing(pugi::xml_node scene, const AssetFolder& folder, std::uint32_t instance, const Glow& glow);
    void declare_ply(pugi::xml_node parent, const std::string& id, const std::string& reference, const Mesh& mesh,
                     bool smooth);
    bool wants_coordinates(const Mesh& mesh) const;

    const SceneModel& model_;
    const std::vector<glm::mat4>& transforms_;
    Materials& materials_;
    std::vector<Form> forms_;  ///< by instance
    /// Instances that become one mesh: of one material, all with vertex normals or all without.
    std::vector<std::vector<std::uint32_t>> merged_;
    std::vector<std::uint8_t> grouped_;  ///< by mesh: whether something is an instance of it
    std::size_t unsampled_glows_ = 0, sampled_glows_ = 0;
};

}  // namespace equistream::mitsuba_xml
