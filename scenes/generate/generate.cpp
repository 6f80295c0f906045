#include "bundled.h"

#include <equistream/error.h>
#include <equistream/locks.h>
#include <equistream/sequence.h>
#include <scenes/generate/breakers/breakers.h>
#include <scenes/library/write_glb.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace equistream {
namespace {

using namespace generate;

constexpr Generator table[] = {
    {"pavilion",
     "a garden pavilion to look at: glass, mirror, copper, leaves, railings, a rolling ball",
     {},
     make_pavilion},
    {"orientation",
     "a room whose six sides cannot be mistaken for one another, flipped or turned",
     {},
     make_orientation},
    {"sphere", "the inside of a sphere mesh, whose depth is known", sphere_options, make_sphere},
    {"furnace", "a white furnace: every pixel of a correct render is 1", furnace_options, make_furnace},
    {"motion", "a glowing room with two moving objects, for motion vectors at the seam and the poles", motion_options,
     make_motion},
    {"materials",
     "a room of what every renderer means the same by: matt, mirrors, panes of glass, textures, masks, lamps",
     {},
     make_materials},
    {"leaf", "breaker: a leaf before the left eye", leaf_options, make_leaf},
    {"near", "breaker: a ball nearer than anything should be", near_options, make_near},
    {"poles", "breaker: looking straight up and down", poles_options, make_poles},
    {"seam", "breaker: a ball across the sphere's seam", seam_options, make_seam},
    {"wires", "breaker: thin bars and rails before a wall", wires_options, make_wires},
    {"mirror", "breaker: a mirror, whose picture lies behind its surface", mirror_options, make_mirror},
    {"glass", "breaker: a pane of glass before a wall", glass_options, make_glass},
    {"inside", "breaker: a head half in a block, or all of it", inside_options, make_inside},
    {"grazing", "breaker: ground to the horizon, seen from just above it", grazing_options, make_grazing},
    {"sky", "breaker: a railing before the sky, near enough to touch", sky_options, make_sky},
    {"empty", "a model with nothing in it, which programs must refuse", {}, make_empty},
};

template <typename Range>
std::string comma_separated(const Range& items) {
    std::string text;
    for (const auto& item : items)
        text += (text.empty() ? "" : ", ") + std::string(item);
    return text;
}

std::string option_place(std::string_view name) {
    return "option " + std::string(name);
}

template <typename T>
T parsed(std::string_view name, const std::string& text, T low, T high) {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
        throw InputError(expected_found(option_place(name),
                                        "a number from " + std::to_string(low) + " to " + std::to_string(high),
                                        "'" + text + "'"));
    return value;
}

}  // namespace

double GeneratorValues::number(std::string_view name, double low, double high) const {
    return parsed(name, values_.find(name)->second, low, high);
}

int GeneratorValues::count(std::string_view name, int low, int high) const {
    return parsed(name, values_.find(name)->second, low, high);
}

const std::string& GeneratorValues::word(std::string_view name, std::span<const std::string_view> accepted) const {
    const std::string& value = values_.find(name)->second;
    if (std::find(accepted.begin(), accepted.end(), value) == accepted.end())
        throw InputError(expected_found(option_place(name), "one of " + comma_separated(accepted), "'" + value + "'"));
    return value;
}

std::span<const Generator> generators() {
    return table;
}

const Generator& find_generator(std::string_view name) {
    std::vector<std::string_view> names;
    for (const Generator& generator : table) {
        if (generator.name == name)
            return generator;
        names.push_back(generator.name);
    }
    throw InputError(expected_found("NAME", "one of " + comma_separated(names), "'" + std::string(name) + "'"));
}

GeneratedScene make_scene(const Generator& generator, std::span<const std::string> settings) {
    std::map<std::string, std::string, std::less<>> values;
    std::vector<std::string_view> names;
    for (const GeneratorOption& option : generator.options) {
        values.emplace(option.name, option.default_value);
        names.push_back(option.name);
    }
    for (const std::string& setting : settings) {
        const std::size_t equals = setting.find('=');
        const auto found = values.find(setting.substr(0, equals));
        if (equals == std::string::npos || found == values.end())
            throw InputError(expected_found(
                "options of " + std::string(generator.name),
                names.empty() ? "none" : "NAME=VALUE with a name of " + comma_separated(names), "'" + setting + "'"));
        found->second = setting.substr(equals + 1);
    }
    GeneratedScene scene = generator.make(GeneratorValues(std::move(values)));
    scene.description.name = generator.name;
    return scene;
}

void add_daylight(SceneDescription& description) {
    const double azimuth = glm::radians(238.0), elevation = glm::radians(45.0);
    description.sun =
        Sun{{std::cos(elevation) * std::sin(azimuth), std::sin(elevation), -std::cos(elevation) * std::cos(azimuth)},
            {3.3, 3.0, 2.5}};
    description.sky_radiance = {0.22, 0.33, 0.52};
    description.exposure = 1.4;
}

std::filesystem::path write_scene(const GeneratedScene& scene, const std::filesystem::path& folder) {
    require_writable_folder(folder);
    const std::string& name = scene.description.name;
    write_glb(folder / (name + ".glb"), scene.model);
    const std::filesystem::path description = folder / (name + ".json");
    write_file_atomically(description, description_text(scene.description));
    return description;
}

}  // namespace equistream
