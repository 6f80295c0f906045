#include "edited_xml.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <mitsuba/core/fresolver.h>
#include <mitsuba/core/transform.h>

#include <algorithm>
#include <initializer_list>
#include <optional>

namespace equistream::mitsuba_host {
namespace {

using mitsuba::ObjectType;
using mitsuba::Properties;
using mitsuba::parser::ParserState;
using mitsuba::parser::SceneNode;
using Reference = Properties::ResolvedReference;
using Transform = mitsuba::AffineTransform<mitsuba::Point<double, 4>>;

struct Child {
    std::string property;
    std::size_t node = 0;
};

std::vector<Child> children(const SceneNode& node, const ParserState& state, ObjectType type) {
    std::vector<Child> found;
    for (const auto& property : node.props.filter(Properties::Type::ResolvedReference)) {
        const std::size_t index = property.get<Reference>().index();
        if (state[index].type == type)
            found.push_back({std::string(property.name()), index});
    }
    return found;
}

std::size_t add_node(ParserState& state, ObjectType type, Properties properties) {
    SceneNode node;
    node.type = type;
    node.props = std::move(properties);
    state.nodes.push_back(std::move(node));
    return state.nodes.size() - 1;
}

Matrix34 rows_of(const Transform& transform) {
    Matrix34 rows{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column)
            rows[row * 4 + column] = transform.matrix.entry(row, column);
    return rows;
}

std::size_t add_film(ParserState& state, const SensorRequest& request) {
    Properties filter("box");
    Properties film("hdrfilm");
    film.set("width", request.width);
    film.set("height", request.height);
    film.set("pixel_format", "rgba");
    film.set("component_format", "float32");
    film.set("rfilter", Reference(add_node(state, ObjectType::ReconstructionFilter, std::move(filter))));
    return add_node(state, ObjectType::Film, std::move(film));
}

/// What stays of the sensor that ours takes the place of.
void keep_from(const SceneNode& theirs, const ParserState& state, Properties& ours) {
    for (const char* clip : {"near_clip", "far_clip"})
        if (theirs.props.has_property(clip))
            ours.set(clip, theirs.props.get<double>(clip));
    for (const Child& medium : children(theirs, state, ObjectType::Medium))
        ours.set("medium", Reference(medium.node));
}

std::size_t add_sensor(ParserState& state, const SensorRequest& request, const SceneNode* theirs, std::size_t index) {
    Properties ours(request.perspective ? "perspective" : "equirect");
    ours.set_id(our_sensor_id(index));
    if (theirs != nullptr)
        keep_from(*theirs, state, ours);
    ours.set("to_world", Transform());
    if (request.perspective) {
        ours.set("fov_axis", "x");
        ours.set("fov", request.fov_x_deg);
    } else {
        ours.set("longitude_min", request.range.longitude_min_deg);
        ours.set("longitude_max", request.range.longitude_max_deg);
        ours.set("latitude_min", request.range.latitude_min_deg);
        ours.set("latitude_max", request.range.latitude_max_deg);
        if (!request.ods_eye.empty()) {
            ours.set("eye", request.ods_eye);
            ours.set("ipd", request.ods_ipd);
        }
    }
    ours.set("film", Reference(add_film(state, request)));
    ours.set("sampler", Reference(add_node(state, ObjectType::Sampler, Properties("independent"))));
    return add_node(state, ObjectType::Sensor, std::move(ours));
}

void replace_sensors(const SceneRequest& request, EditedXml& xml) {
    ParserState& state = xml.state;
    const std::vector<Child> theirs = children(state.root(), state, ObjectType::Sensor);
    xml.sensor.count = static_cast<int>(theirs.size());
    if (request.sensor != 0 && request.sensor >= xml.sensor.count)
        throw InputError(expected_found("--sensor",
                                        "a number below the XML's " + std::to_string(xml.sensor.count) + " sensors",
                                        std::to_string(request.sensor)));
    // A copy: adding nodes moves them.
    std::optional<SceneNode> chosen;
    if (!theirs.empty())
        chosen = state[theirs[static_cast<std::size_t>(request.sensor)].node];
    xml.sensor.has_pose = chosen && chosen->props.has_property("to_world");
    if (xml.sensor.has_pose)
        xml.sensor.to_world = rows_of(chosen->props.get<Transform>("to_world"));
    // Mitsuba's flat sensors have these defaults.
    if (!request.sensors.empty() && request.sensors.front().perspective) {
        xml.sensor.near_clip = 1e-2;
        xml.sensor.far_clip = 1e4;
    }
    for (const auto& [name, clip] :
         {std::pair("near_clip", &xml.sensor.near_clip), std::pair("far_clip", &xml.sensor.far_clip)})
        if (chosen && chosen->props.has_property(name)) {
            *clip = chosen->props.get<double>(name);
            xml.sensor.has_clips = true;
        }
    for (const Child& child : theirs)
        state.root().props.remove_property(child.property);
    for (std::size_t i = 0; i < request.sensors.size(); ++i) {
        const std::size_t node = add_sensor(state, request.sensors[i], chosen ? &*chosen : nullptr, i);
        state.root().props.set(our_sensor_id(i), Reference(node));
    }
}

/// Whether lamps are to be looked through: of this integrator or of one nested in it.
bool hides_emitters(const ParserState& state, std::size_t node) {
    const Properties& props = state[node].props;
    if (props.has_property("hide_emitters") && props.type("hide_emitters") == Properties::Type::Bool) {
        const bool hides = props.get<bool>("hide_emitters");
        props.mark_queried("hide_emitters", false);
        if (hides)
            return true;
    }
    const std::vector<Child> nested = children(state[node], state, ObjectType::Integrator);
    return std::any_of(nested.begin(), nested.end(),
                       [&](const Child& child) { return hides_emitters(state, child.node); });
}

bool is_one_of(const SceneNode& node, std::initializer_list<const char*> plugins) {
    return std::any_of(plugins.begin(), plugins.end(),
                       [&](const char* plugin) { return node.props.plugin_name() == plugin; });
}

/// What renders colour. Wrappers add channels that nothing here asks for, at the cost of another render. Some of their
/// channels have names of ours.
std::size_t colour_of(const ParserState& state, std::size_t node) {
    while (is_one_of(state[node], {"equirect_aov", "aov", "moment", "stokes"})) {
        const std::vector<Child> nested = children(state[node], state, ObjectType::Integrator);
        if (nested.empty())
            break;
        node = nested.front().node;
    }
    return node;
}

/// Passes are ours, and have as many samples as we say.
void remove_passes(Properties& integrator) {
    for (const char* of_passes : {"samples_per_pass", "timeout", "block_size"})
        if (integrator.has_property(of_passes))
            integrator.remove_property(of_passes);
}

void wrap_integrator(const SceneRequest& request, EditedXml& xml) {
    ParserState& state = xml.state;
    const std::vector<Child> theirs = children(state.root(), state, ObjectType::Integrator);
    for (const Child& child : theirs)
        state.root().props.remove_property(child.property);
    const std::size_t nested = theirs.empty() ? add_node(state, ObjectType::Integrator, Properties("path"))
                                              : colour_of(state, theirs.front().node);
    Properties& colour = state[nested].props;
    remove_passes(colour);
    if (request.max_depth > 0) {
        if (is_one_of(state[nested], {"direct", "depth"}))
            throw InputError(expected_found("--max-bounces", "an integrator of paths, such as \"path\", in the XML",
                                            "\"" + std::string(colour.plugin_name()) + "\""));
        colour.set("max_depth", request.max_depth, false);
    }
    // Ours hides lamps by itself; the others leave that to what they wrap.
    const bool is_ours = !theirs.empty() && is_one_of(state[theirs.front().node], {"equirect_aov"});
    xml.hides_emitters = hides_emitters(state, is_ours ? theirs.front().node : nested);
    Properties ours("equirect_aov");
    ours.set("hide_emitters", xml.hides_emitters);
    ours.set_id(our_integrator_id);
    ours.set("aovs", request.aovs);
    ours.set("integrator", Reference(nested));
    // Adding nodes moves the root, so it comes first.
    const std::size_t node = add_node(state, ObjectType::Integrator, std::move(ours));
    state.root().props.set(our_integrator_id, Reference(node));
}

/// Shapes and materials are told apart by their ids, which XML need not give.
void name_the_nameless(ParserState& state) {
    for (std::size_t i = 0; i < state.nodes.size(); ++i) {
        SceneNode& node = state.nodes[i];
        if ((node.type != ObjectType::Shape && node.type != ObjectType::BSDF) || !node.props.id().empty())
            continue;
        std::string id = std::string(node.props.plugin_name()) + "-" + std::to_string(i);
        while (state.id_to_index.find(id) != state.id_to_index.end())
            id += "-";
        node.props.set_id(id);
    }
}

std::map<std::string, std::string> find_groups(const ParserState& state) {
    std::map<std::string, std::string> groups;
    for (const SceneNode& node : state.nodes)
        if (node.type == ObjectType::Shape && node.props.plugin_name() == "instance")
            for (const Child& child : children(node, state, ObjectType::Shape))
                groups[std::string(node.props.id())] = std::string(state[child.node].props.id());
    return groups;
}

/// Every file whose bytes decide what is seen.
std::vector<std::filesystem::path> named_files(const ParserState& state) {
    std::vector<std::filesystem::path> files;
    for (const auto& file : state.files)
        files.emplace_back(file.string());
    for (const SceneNode& node : state.nodes)
        for (const auto& property : node.props.filter(Properties::Type::String)) {
            const std::string name = node.props.get<std::string>(property.name());
            std::error_code error;
            const std::filesystem::path file = mitsuba::file_resolver()->resolve(name).string();
            if (!name.empty() && std::filesystem::is_regular_file(file, error))
                files.push_back(file);
            node.props.mark_queried(property.name(), false);
        }
    return files;
}

/// Spectra are read from their files while the XML is parsed, and the files' names are lost.
std::string spectra_text(const ParserState& state) {
    std::string text;
    for (const SceneNode& node : state.nodes)
        for (const auto& property : node.props.filter(Properties::Type::Spectrum)) {
            const auto spectrum = node.props.get<Properties::Spectrum>(property.name());
            for (const auto* numbers : {&spectrum.wavelengths, &spectrum.values})
                for (const double number : *numbers)
                    text += in_words(number) + " ";
            text += "\n";
            node.props.mark_queried(property.name(), false);
        }
    return text;
}

}  // namespace

std::string our_sensor_id(std::size_t index) {
    return "equistream_sensor_" + std::to_string(index);
}

EditedXml read_and_edit(const SceneRequest& request, const std::string& variant) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(request.xml, error))
        throw InputError(expected_found(request.xml.string(), "a scene in Mitsuba's XML", "no such file"));
    EditedXml xml{mitsuba::parser::ParserConfig(variant), {}, {}, false, {}};
    // Shapes keep their own ids, names and places in the tables of the AOV integrator.
    xml.config.merge_meshes = false;
    mitsuba::FileResolver& resolver = *mitsuba::file_resolver();
    const mitsuba::filesystem::path folder = std::filesystem::absolute(request.xml).parent_path().string();
    if (!resolver.contains(folder))
        resolver.append(folder);
    try {
        xml.state = mitsuba::parser::parse_file(xml.config, request.xml.string(), request.parameters);
        if (xml.state.empty() || xml.state.root().type != ObjectType::Scene)
            throw std::runtime_error(expected_found(request.xml.string(), "a <scene> as root", "another element"));
        mitsuba::parser::transform_upgrade(xml.config, xml.state);
        mitsuba::parser::transform_resolve(xml.config, xml.state);
        xml.sensor.files = named_files(xml.state);
        xml.sensor.spectra = spectra_text(xml.state);
        // Before ours are there: two of our sensors may be alike.
        mitsuba::parser::transform_merge_equivalent(xml.config, xml.state);
        replace_sensors(request, xml);
        wrap_integrator(request, xml);
        name_the_nameless(xml.state);
        xml.group_of_instance = find_groups(xml.state);
    } catch (const InputError&) {
        throw;
    } catch (const std::exception& problem) {
        throw InputError(quotable(one_line(problem.what()), 900));
    }
    return xml;
}

namespace {

constexpr const char* zero_width_space = "\xe2\x80\x8b";

std::string without(std::string text, const std::string& part) {
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at))
        text.erase(at, part.size());
    return text;
}

}  // namespace

std::string one_line(const std::string& message) {
    std::string line;
    for (const char c : without(message, zero_width_space)) {
        const bool blank = static_cast<unsigned char>(c) <= 0x20;
        if (!blank)
            line += c;
        else if (!line.empty() && line.back() != ' ')
            line += ' ';
    }
    while (!line.empty() && line.back() == ' ')
        line.pop_back();
    return line;
}

}  // namespace equistream::mitsuba_host
