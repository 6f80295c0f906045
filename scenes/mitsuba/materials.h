#pragma once
/// Our materials as Mitsuba BSDFs.
#include "images.h"

namespace equistream::mitsuba_xml {

/// How often our materials became something that is near, but not the same.
struct MaterialNotes {
    std::size_t principled = 0;   ///< metal-rough: principled
    std::size_t metals = 0;       ///< Fresnel's equations for Schlick's, light lost by rough metals not given back
    std::size_t mixed_glass = 0;  ///< partly transmitting or metallic: blended with principled and conductor
};

class Materials {
public:
    Materials(const SceneModel& model, Images& images) : model_(model), images_(images) {}

    /// The id of the BSDF for a mesh: material-K, or material-K-whole for a masked material on a mesh that its mask
    /// does not cut (SceneModel::mask_of). Call for every mesh before declare().
    std::string id_for(const Mesh& mesh);
    /// Index of a mesh's material.
    std::uint32_t index_for(const Mesh& mesh) const;

    void ask_for_images();
    void declare(pugi::xml_node scene);
    const MaterialNotes& notes() const { return notes_; }
    /// Whether rays go on straight behind some surface: glass, or what a mask cut away.
    bool any_straight() const { return any_straight_; }

private:
    struct Use {
        std::uint32_t material = 0, mask = no_index;
    };

    void add_bsdf(pugi::xml_node parent, const std::string& id, const Use& use);
    void add_opaque(pugi::xml_node parent, const Material& material, const std::string& id);
    void add_metal(pugi::xml_node parent, const Material& material, const std::string& id);
    void add_principled(pugi::xml_node parent, const Material& material, const std::string& id);
    void add_glass(pugi::xml_node parent, const Material& material, const std::string& id);
    void add_base_colour(pugi::xml_node parent, const Material& material, const char* name);

    const SceneModel& model_;
    Images& images_;
    std::map<std::string, Use> uses_;
    MaterialNotes notes_;
    bool any_straight_ = false;
};

/// A conductor's complex index of refraction whose reflectance follows Schlick's curve from `f0` at normal incidence
/// (below 1) to 1: both agree at normal incidence, and as well as they can on the way.
struct ComplexIndex {
    double eta = 0, k = 0;
};
ComplexIndex schlick_conductor(double f0);

}  // namespace equistream::mitsuba_xml
