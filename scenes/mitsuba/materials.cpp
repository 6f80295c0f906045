#include "materials.h"

#include "xml.h"

#include <scenes/library/model.h>

#include <algorithm>
#include <cmath>

namespace equistream::mitsuba_xml {
namespace {

double schlick(double f0, double cosine) {
    return f0 + (1 - f0) * std::pow(1 - cosine, 5);
}

/// Unpolarised reflectance of a conductor in air.
double conductor_reflectance(const ComplexIndex& index, double cosine) {
    const double c2 = cosine * cosine, s2 = 1 - c2;
    const double n2 = index.eta * index.eta, k2 = index.k * index.k;
    const double t0 = n2 - k2 - s2;
    const double both = std::sqrt(t0 * t0 + 4 * n2 * k2);
    const double a = std::sqrt(std::max(0.0, 0.5 * (both + t0)));
    const double across = (both + c2 - 2 * a * cosine) / (both + c2 + 2 * a * cosine);
    const double along =
        across * (c2 * both + s2 * s2 - 2 * a * cosine * s2) / (c2 * both + s2 * s2 + 2 * a * cosine * s2);
    return 0.5 * (across + along);
}

double distance_from_schlick(const ComplexIndex& index, double f0) {
    double sum = 0;
    for (int i = 0; i < 64; ++i) {
        const double cosine = (i + 0.5) / 64;
        const double apart = conductor_reflectance(index, cosine) - schlick(f0, cosine);
        sum += cosine * apart * apart;
    }
    return sum;
}

}  // namespace

/// With the reflectance at normal incidence fixed, eta may lie between two values and gives k.
ComplexIndex schlick_conductor(double f0) {
    const double r = std::clamp(f0, 0.0, 0.9999), root = std::sqrt(r);
    const double low = (1 - r) / (1 + r), high = (1 + root) / (1 - root);
    constexpr int steps = 256;
    ComplexIndex best;
    double least = 1e30;
    for (int i = 0; i <= steps; ++i) {
        const double eta = low * std::pow(high / low, static_cast<double>(i) / steps);
        const double k2 = (r * (eta + 1) * (eta + 1) - (eta - 1) * (eta - 1)) / (1 - r);
        const ComplexIndex index{eta, std::sqrt(std::max(0.0, k2))};
        const double distance = distance_from_schlick(index, r);
        if (distance < least) {
            least = distance;
            best = index;
        }
    }
    return best;
}

std::uint32_t Materials::index_for(const Mesh& mesh) const {
    return std::min(mesh.material, static_cast<std::uint32_t>(model_.materials.size() - 1));
}

std::string Materials::id_for(const Mesh& mesh) {
    const std::uint32_t index = index_for(mesh);
    const bool masked = model_.materials[index].alpha_mask != no_index, cut = model_.mask_of(mesh) != no_index;
    const std::string id = "material-" + std::to_string(index) + (masked && !cut ? "-whole" : "");
    uses_.try_emplace(id, Use{index, cut ? model_.materials[index].alpha_mask : no_index});
    return id;
}

/// Declaring once into a document that is thrown away names every image.
void Materials::ask_for_images() {
    pugi::xml_document rehearsal;
    for (const auto& [id, use] : uses_)
        add_bsdf(rehearsal.append_child("scene"), id, use);
}

void Materials::declare(pugi::xml_node scene) {
    notes_ = {};
    for (const auto& [id, use] : uses_)
        add_bsdf(scene, id, use);
}

void Materials::add_bsdf(pugi::xml_node parent, const std::string& id, const Use& use) {
    const Material& material = model_.materials[use.material];
    const bool glass = material.transmission > 0;
    any_straight_ = any_straight_ || glass || use.mask != no_index;
    if (use.mask == no_index)
        return glass ? add_glass(parent, material, id) : add_opaque(parent, material, id);
    pugi::xml_node node = add_plugin(parent, "bsdf", "mask", id);
    const AlphaMask& mask = model_.alpha_masks[use.mask];
    if (mask.opaque.size() == 1)
        add_float(node, "opacity", mask.opaque[0] != 0);
    else
        add_reference(node, images_.mask(use.mask), "opacity");
    glass ? add_glass(node, material, "") : add_opaque(node, material, "");
}

/// Our surfaces reflect on both sides; Mitsuba's on the front only unless told so.
void Materials::add_opaque(pugi::xml_node parent, const Material& material, const std::string& id) {
    pugi::xml_node node = add_plugin(parent, "bsdf", "twosided", id);
    const bool textured =
        material.metallic_roughness_texture != no_index && !(material.metallic == 0 && material.roughness == 0);
    if (material.metallic == 0 && material.index_of_refraction == 1)
        add_base_colour(add_plugin(node, "bsdf", "diffuse"), material, "reflectance");
    else if (material.metallic == 1 && !textured)
        add_metal(node, material, "");
    else
        add_principled(node, material, "");
}

void Materials::add_metal(pugi::xml_node parent, const Material& material, const std::string& id) {
    const bool smooth = material.roughness < mirror_roughness;
    const bool coloured = material.base_colour_texture != no_index;
    if (coloured && !smooth)
        return add_principled(parent, material, id);
    pugi::xml_node node = add_plugin(parent, "bsdf", smooth ? "conductor" : "roughconductor", id);
    const glm::dvec3 f0(material.base_colour);
    if (coloured || f0 == glm::dvec3(1)) {
        add_text(node, "material", "none");
        add_base_colour(node, material, "specular_reflectance");
        notes_.metals += coloured || !smooth;
    } else {
        glm::dvec3 eta, k;
        for (int c = 0; c < 3; ++c) {
            const ComplexIndex index = schlick_conductor(f0[c]);
            eta[c] = index.eta;
            k[c] = index.k;
        }
        add_rgb(node, "eta", eta);
        add_rgb(node, "k", k);
        ++notes_.metals;
    }
    if (!smooth) {
        add_text(node, "distribution", "ggx");
        add_float(node, "alpha", material.roughness * material.roughness);
    }
}

void Materials::add_principled(pugi::xml_node parent, const Material& material, const std::string& id) {
    pugi::xml_node node = add_plugin(parent, "bsdf", "principled", id);
    add_base_colour(node, material, "base_color");
    add_float(node, "eta", material.index_of_refraction);
    if (material.metallic_roughness_texture == no_index) {
        add_float(node, "metallic", material.metallic);
        add_float(node, "roughness", material.transmission > 0 ? 0 : material.roughness);
    } else {
        add_reference(node, images_.channel(material.metallic_roughness_texture, 2, material.metallic), "metallic");
        add_reference(node, images_.channel(material.metallic_roughness_texture, 1, material.roughness), "roughness");
    }
    ++notes_.principled;
}

/// What our glass does is shared out in this order: metal, what goes straight through, the opaque rest.
void Materials::add_glass(pugi::xml_node parent, const Material& material, const std::string& id) {
    pugi::xml_node node = parent;
    std::string own_id = id;
    const auto blend = [&](double weight, const auto& add_first) {
        node = add_plugin(node, "bsdf", "blendbsdf", own_id);
        own_id.clear();
        add_float(node, "weight", weight);
        add_first(add_plugin(node, "bsdf", "twosided"));
    };
    if (material.metallic > 0)
        blend(1 - material.metallic, [&](pugi::xml_node first) {
            pugi::xml_node conductor = add_plugin(first, "bsdf", "conductor");
            add_text(conductor, "material", "none");
            add_base_colour(conductor, material, "specular_reflectance");
        });
    if (material.transmission < 1)
        blend(material.transmission, [&](pugi::xml_node first) { add_principled(first, material, ""); });
    node = add_plugin(node, "bsdf", "thindielectric", own_id);
    add_float(node, "int_ior", material.index_of_refraction);
    add_float(node, "ext_ior", 1);
    add_base_colour(node, material, "specular_transmittance");
    notes_.mixed_glass += material.metallic > 0 || material.transmission < 1;
}

void Materials::add_base_colour(pugi::xml_node parent, const Material& material, const char* name) {
    if (material.base_colour_texture == no_index)
        return add_rgb(parent, name, glm::dvec3(material.base_colour));
    add_reference(parent, images_.colour(material.base_colour_texture, material.base_colour), name);
}

}  // namespace equistream::mitsuba_xml
