#include "source_conventions.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace equistream::files {

namespace {

struct Preset {
    const char* name;
    SourceConventions (*make)();
};

// Sources of every fact below: docs/import.md.

SourceConventions none() {
    return {};
}

SourceConventions ours() {
    SourceConventions c;
    c.name = "equistream";
    c.backward = MotionConvention{MotionEnds::to_previous, MotionUnit::pixels, false};
    c.forward = MotionConvention{MotionEnds::to_next, MotionUnit::pixels, false};
    return c;
}

SourceConventions cycles() {
    SourceConventions c;
    c.name = "cycles";
    c.depth = DepthKind::planar;  // radial for panoramas: choose_depth
    c.backward = MotionConvention{MotionEnds::to_previous, MotionUnit::pixels, true};
    c.forward = MotionConvention{MotionEnds::from_next, MotionUnit::pixels, true};
    c.z_up = true;
    return c;
}

SourceConventions luxcore() {
    SourceConventions c;
    c.name = "luxcore";
    c.z_up = true;
    c.one_row_low = true;
    return c;
}

SourceConventions mitsuba() {
    SourceConventions c;
    c.name = "mitsuba";
    c.near_plane_m = 0.01;
    c.miss_value = 0;
    return c;
}

SourceConventions pbrt() {
    SourceConventions c;
    c.name = "pbrt";
    c.depth = DepthKind::position;
    c.miss_value = 0;
    c.normals = NormalSpace::camera_z_forward;
    c.mirrored = true;
    c.forward_at = 0.75;  // of the mirrored image
    c.column_vectors = true;
    return c;
}

constexpr Preset presets[] = {{"none", none},       {"cycles", cycles},   {"equistream", ours},
                              {"luxcore", luxcore}, {"mitsuba", mitsuba}, {"pbrt", pbrt}};

}  // namespace

MotionConvention parse_motion(std::string_view words, const char* option) {
    MotionConvention motion;
    const std::vector<std::pair<std::string_view, std::function<void()>>> known = {
        {"to-previous", [&] { motion.ends = MotionEnds::to_previous; }},
        {"from-previous", [&] { motion.ends = MotionEnds::from_previous; }},
        {"to-next", [&] { motion.ends = MotionEnds::to_next; }},
        {"from-next", [&] { motion.ends = MotionEnds::from_next; }},
        {"pixels", [&] { motion.unit = MotionUnit::pixels; }},
        {"normalised", [&] { motion.unit = MotionUnit::normalised; }},
        {"ndc", [&] { motion.unit = MotionUnit::ndc; }},
        {"y-up", [&] { motion.y_up = true; }},
        {"y-down", [&] { motion.y_up = false; }}};
    for (const std::string_view word : split_at_commas(words)) {
        const auto found = std::ranges::find(known, word, [](const auto& entry) { return entry.first; });
        if (found == known.end())
            throw InputError(expected_found(option,
                                            "words of to-previous, from-previous, to-next, from-next; pixels, "
                                            "normalised, ndc; y-up, y-down",
                                            "'" + std::string(word) + "'"));
        found->second();
    }
    return motion;
}

std::string motion_text(const MotionConvention& motion) {
    constexpr const char* ends[] = {"to-previous", "from-previous", "to-next", "from-next"};
    constexpr const char* units[] = {"pixels", "normalised", "ndc"};
    return std::string(ends[int(motion.ends)]) + "," + units[int(motion.unit)] + (motion.y_up ? ",y-up" : ",y-down");
}

std::string identity_of(const SourceConventions& c) {
    const auto motion = [](const auto& m) { return m ? motion_text(*m) : std::string("none"); };
    return c.name +
           formatted("\ndepth %d %.17g %.17g miss %.17g %.17g", int(c.depth), c.depth_scale_m, c.near_plane_m,
                     c.miss_value.value_or(std::numeric_limits<double>::quiet_NaN()), c.miss_above) +
           "\nmotion " + motion(c.backward) + " " + motion(c.forward) +
           formatted("\nnormals %d %d\nworld %d %d %.17g %d", int(c.normals), int(c.normals_encoded), int(c.mirrored),
                     int(c.z_up), c.forward_at, int(c.column_vectors)) +
           (c.one_row_low ? "\none row low" : "");
}

std::vector<std::string> preset_names() {
    std::vector<std::string> names;
    for (const Preset& entry : presets)
        names.emplace_back(entry.name);
    return names;
}

SourceConventions preset(const std::string& name) {
    std::string accepted = "auto";
    for (const Preset& entry : presets) {
        if (name == entry.name)
            return entry.make();
        accepted += std::string(", ") + entry.name;
    }
    throw InputError(expected_found("--preset", accepted, "'" + name + "'"));
}

std::string guess_preset(const ForeignExr& file) {
    const std::string software = file.software();
    const auto has = [&](std::string_view plain) {
        return std::ranges::any_of(file.channels(), [&](const ForeignChannel& c) { return c.plain == plain; });
    };
    // Mitsuba's integrator `aov` calls distance by another letter, and Z a position's part.
    const bool is_by_our_plugin = software.find("Mitsuba") != std::string::npos && !has("depth.X");
    if (file.is_our_own() || (has("depth.Z") && (is_by_our_plugin || has("backward.u") || has("object_id"))))
        return "equistream";
    if (software.find("Blender") != std::string::npos || has("ViewLayer.Combined.R") || has("RenderLayer.Combined.R"))
        return "cycles";
    if (software.find("Mitsuba") != std::string::npos)
        return "mitsuba";
    if (has("dzdx") && has("P.Z"))
        return "pbrt";
    return "none";
}

}  // namespace equistream::files
