#include "lights.h"

#include "xml.h"

#include <equistream/error.h>
#include <scenes/sky/sky_image.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace equistream::mitsuba_xml {
namespace {

/// The sun moves by a millionth of a radian from one end of the scene to the other.
constexpr double sun_distance_in_radii = 1e6;
constexpr double widest_sun_rad = 85 * std::numbers::pi / 180;

/// A transform that takes the unit disc, which faces +Z, to a disc facing `normal`.
glm::dmat4 disc_transform(const glm::dvec3& centre, const glm::dvec3& normal, double radius_m) {
    const glm::dvec3 other = std::abs(normal.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(other, normal)), y = glm::cross(normal, x);
    return {glm::dvec4(radius_m * x, 0), glm::dvec4(radius_m * y, 0), glm::dvec4(radius_m * normal, 0),
            glm::dvec4(centre, 1)};
}

/// Mitsuba's first and last rows lie on the poles, ours half a pixel away from them. With a row of means between each
/// two of ours, and the outer rows twice, interpolation between its rows is interpolation between ours.
FloatImage on_mitsubas_grid(const FloatImage& image, const glm::vec3& scale) {
    FloatImage result(image.width(), 2 * image.height() + 1, 3);
    for (int y = 0; y < result.height(); ++y) {
        const int above = std::max(0, (y - 1) / 2), below = std::min(image.height() - 1, y / 2);
        for (int x = 0; x < result.width(); ++x)
            for (int c = 0; c < 3; ++c)
                result.pixel(x, y)[c] = 0.5f * (image.pixel(x, above)[c] + image.pixel(x, below)[c]) * scale[c];
    }
    return result;
}

/// Mitsuba's image begins at -Z, where ours has its middle: half a turn.
glm::dmat4 turned_about_y(double angle_rad) {
    return glm::rotate(glm::dmat4(1), angle_rad, glm::dvec3(0, 1, 0));
}

void add_sky_image(pugi::xml_node scene, const SkyImage& sky, AssetFolder& folder) {
    const FloatImage image = on_mitsubas_grid(read_sky_image(sky.file), glm::vec3(sky.scale));
    write_linear_image(folder, "sky.exr", image);
    pugi::xml_node node = add_plugin(scene, "emitter", "envmap", "sky");
    add_text(node, "filename", folder.reference_to("sky.exr"));
    add_transform(node, "to_world", turned_about_y(sky.rotation_rad + std::numbers::pi));
}

}  // namespace

double sun_distance_m(const Bounds& bounds) {
    return sun_distance_in_radii * std::max(bounds.radius_m, 1e-3);
}

void add_sky(pugi::xml_node scene, const SceneDescription& description, AssetFolder& folder) {
    if (description.sky_image)
        return add_sky_image(scene, *description.sky_image, folder);
    if (description.sky_radiance == glm::dvec3(0))
        return;
    pugi::xml_node node = add_plugin(scene, "emitter", "constant", "sky");
    add_rgb(node, "radiance", description.sky_radiance);
}

void add_darkness(pugi::xml_node scene) {
    add_rgb(add_plugin(scene, "emitter", "constant", "darkness"), "radiance", glm::dvec3(0));
}

void add_sun(pugi::xml_node scene, const SceneDescription& description, const Bounds& bounds) {
    if (!description.sun || description.sun->irradiance == glm::dvec3(0))
        return;
    const Sun& sun = *description.sun;
    if (sun.angular_radius_rad > widest_sun_rad)
        throw InputError(expected_found(description.file.string() + ": sun", "an angular radius of at most 85 degrees",
                                        std::to_string(sun.angular_radius_rad * 180 / std::numbers::pi)));
    const double distance = sun_distance_m(bounds), sine = std::sin(sun.angular_radius_rad);
    pugi::xml_node node = add_plugin(scene, "shape", "disk", "sun");
    add_transform(node, "to_world",
                  disc_transform(bounds.centre + distance * sun.towards, -sun.towards,
                                 distance * std::tan(sun.angular_radius_rad)));
    add_plugin(node, "bsdf", "null");
    add_rgb(add_plugin(node, "emitter", "area"), "radiance", sun.irradiance / (std::numbers::pi * sine * sine));
}

void add_emitter(pugi::xml_node shape, const Material& material, const std::string& emission_image, double share) {
    pugi::xml_node node = add_plugin(shape, "emitter", "area");
    if (emission_image.empty())
        add_rgb(node, "radiance", glm::dvec3(material.emission));
    else
        add_reference(node, emission_image, "radiance");
    add_float(node, "sampling_weight", share);
}

/// Counts on a grid: no point of it may lie in two triangles.
bool maps_one_to_one(const Mesh& mesh) {
    if (mesh.uvs.empty())
        return false;
    constexpr int side = 512;
    std::vector<std::uint8_t> taken(static_cast<std::size_t>(side) * side, 0);
    for (const glm::vec2& uv : mesh.uvs)
        if (!(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1))
            return false;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec2 a(mesh.uvs[t.x]), b(mesh.uvs[t.y]), c(mesh.uvs[t.z]);
        const auto side_of = [](const glm::dvec2& p, const glm::dvec2& q, const glm::dvec2& at) {
            return (q.x - p.x) * (at.y - p.y) - (q.y - p.y) * (at.x - p.x);
        };
        const double area = side_of(a, b, c);
        if (area == 0)
            return false;
        const glm::dvec2 low = glm::min(a, glm::min(b, c)) * double{side},
                         high = glm::max(a, glm::max(b, c)) * double{side};
        for (int y = static_cast<int>(low.y); y <= std::min(static_cast<int>(high.y), side - 1); ++y)
            for (int x = static_cast<int>(low.x); x <= std::min(static_cast<int>(high.x), side - 1); ++x) {
                // Off the texels' centres, where edges of tidy maps run.
                const glm::dvec2 p{(x + 0.5123) / side, (y + 0.4871) / side};
                if (side_of(a, b, p) / area <= 0 || side_of(b, c, p) / area <= 0 || side_of(c, a, p) / area <= 0)
                    continue;
                if (taken[static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x)]++)
                    return false;
            }
    }
    return true;
}

}  // namespace equistream::mitsuba_xml
