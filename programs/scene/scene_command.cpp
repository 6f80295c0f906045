/// equistream scene: generate NAME --out DIR, info SCENE, describe MODEL, placements SCENE, convert SCENE OUT.
#include "describe.h"
#include "summary.h"

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <programs/cli/commands.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>
#include <scenes/generate/generate.h>
#include <scenes/library/file_bytes.h>
#include <scenes/library/write_glb.h>
#include <scenes/mitsuba/convert.h>
#include <scenes/mitsuba/old_scene.h>

#include <nlohmann/json.hpp>

#include <cstdio>
#include <memory>
#include <sstream>
#include <system_error>

namespace equistream {
namespace {

struct GenerateArguments {
    std::string command, name, folder;
    std::vector<std::string> options;
    std::string knob;
    bool list = false;
    bool overwrite = false;
    bool json = false;
};

struct InfoArguments {
    std::string command, scene;
    bool json = false;
};

struct ConvertArguments {
    std::string command, scene, out;
    std::string camera = "perspective";
    std::string size;
    bool json = false;
    MitsubaSettings settings;
};

void print(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
}

void print_json(const std::string& command, const nlohmann::ordered_json& report) {
    nlohmann::ordered_json json = cli::provenance(command);
    json.update(report);
    print(json_text(json, 2) + "\n");
}

nlohmann::ordered_json listed(const Generator& generator) {
    nlohmann::ordered_json options = nlohmann::ordered_json::array();
    for (const GeneratorOption& option : generator.options)
        options.push_back({{"name", option.name}, {"default", option.default_value}, {"meaning", option.meaning}});
    return {{"name", generator.name}, {"summary", generator.summary}, {"options", options}};
}

void list_generators(const GenerateArguments& arguments) {
    if (arguments.json) {
        nlohmann::ordered_json scenes = nlohmann::ordered_json::array();
        for (const Generator& generator : generators())
            scenes.push_back(listed(generator));
        return print_json(arguments.command, {{"scenes", scenes}});
    }
    for (const Generator& generator : generators()) {
        std::printf("%-12.*s%.*s\n", static_cast<int>(generator.name.size()), generator.name.data(),
                    static_cast<int>(generator.summary.size()), generator.summary.data());
        for (const GeneratorOption& option : generator.options)
            print("              --option " + std::string(option.name) + "=" + std::string(option.default_value) +
                  ": " + std::string(option.meaning) + "\n");
    }
}

/// A scene made by the same command before may be replaced; one that its user has changed since may not.
void require_no_other(const GeneratedScene& scene, const std::filesystem::path& folder) {
    const std::filesystem::path stem = folder / scene.description.name;
    const auto require_same = [&](const std::string& extension, const std::string& what, const auto& made) {
        const std::filesystem::path file = stem.string() + extension;
        std::error_code error;
        if (!std::filesystem::exists(file, error))
            return;
        std::ostringstream there;
        there << open_regular_file(file, what).rdbuf();
        if (there.str() != made())
            throw InputError(expected_found(file.string(), "no " + what + ", or one that this command made",
                                            "another one; choose another folder or --overwrite"));
    };
    require_same(".json", "scene", [&] { return description_text(scene.description); });
    // Of some options the description says nothing.
    require_same(".glb", "model", [&] { return glb_bytes(scene.model); });
}

const Generator& generator_called(const std::string& name) {
    try {
        return find_generator(name);
    } catch (const InputError& error) {
        std::vector<std::string_view> names;
        for (const Generator& generator : generators())
            names.push_back(generator.name);
        throw InputError(error.what() + cli::did_you_mean(name, names));
    }
}

void generate(const GenerateArguments& arguments) {
    if (arguments.list)
        return list_generators(arguments);
    if (arguments.name.empty() || arguments.folder.empty())
        throw InputError("generate: expected a scene's name and --out DIR (--list shows the names)");
    const Generator& generator = generator_called(arguments.name);
    std::vector<std::string> settings = arguments.options;
    if (!arguments.knob.empty()) {
        if (generator.options.empty())
            throw InputError(expected_found("--knob", "a scene with options", arguments.name + ", which has none"));
        settings.push_back(std::string(generator.options.front().name) + "=" + arguments.knob);
    }
    const GeneratedScene scene = make_scene(generator, settings);
    if (!arguments.overwrite)
        require_no_other(scene, arguments.folder);
    const std::filesystem::path description = write_scene(scene, arguments.folder);
    const auto triangles = scene.model.triangle_count();
    if (arguments.json)
        return print_json(arguments.command, {{"scene", description.string()}, {"triangles", triangles}});
    print(description.string() + ": " + std::to_string(triangles) + " triangles\n");
}

/// Of a scene in Mitsuba's XML: what keeps Mitsuba 3 from reading it.
void info_of_xml(const InfoArguments& arguments) {
    const std::vector<std::string> changes = mitsuba_xml::changes_for_mitsuba3(arguments.scene);
    if (arguments.json)
        return print_json(arguments.command, {{"must_change", changes}});
    for (const std::string& change : changes)
        print(change + "\n");
    print(changes.empty() ? arguments.scene + ": nothing of Mitsuba 0.6; render --host mitsuba renders it\n"
                          : std::to_string(changes.size()) + " things must change for Mitsuba 3\n");
}

void info(const InfoArguments& arguments) {
    if (std::filesystem::path(arguments.scene).extension() == ".xml")
        return info_of_xml(arguments);
    const SceneDescription scene = load_scene(arguments.scene);
    const SceneModel model = load_model(scene);
    for (const std::string& note : model.notes)
        std::fprintf(stderr, "equistream scene: %s\n", note.c_str());
    const SceneSummary summary = summarise(model, scene);
    if (arguments.json) {
        nlohmann::ordered_json json = summary_json(summary);
        json["fingerprint"] = scene.fingerprint;
        return print_json(arguments.command, json);
    }
    print(summary_text(summary));
}

void placements(const std::string& scene) {
    print(placements_json(load_model(load_scene(scene))));
}

nlohmann::ordered_json as_json(const MitsubaReport& report, const std::vector<std::string>& notes) {
    nlohmann::ordered_json json;
    json["triangles"] = report.triangles;
    json["shapes"] = report.shapes;
    json["instances"] = report.instances;
    json["groups"] = report.groups;
    json["images"] = report.images;
    json["bytes"] = report.bytes;
    json["notes"] = notes;
    return json;
}

void convert(const ConvertArguments& arguments) {
    MitsubaSettings settings = arguments.settings;
    settings.camera = arguments.camera == "equirect" ? MitsubaCamera::equirect : MitsubaCamera::perspective;
    if (!arguments.size.empty()) {
        const cli::Size size = cli::parse_size(arguments.size);
        settings.width = size.width;
        settings.height = size.height;
    }
    const std::filesystem::path out = arguments.out;
    cli::require(out.extension() == ".xml", arguments.out, "a name that ends in .xml",
                 "'" + out.extension().string() + "'");
    const SceneDescription scene = load_scene(arguments.scene);
    const SceneModel model = load_model(scene);
    const MitsubaReport report = write_mitsuba_scene(model, scene, out, settings);
    std::vector<std::string> notes = model.notes;
    notes.insert(notes.end(), report.notes.begin(), report.notes.end());
    if (arguments.json)
        return print_json(arguments.command, as_json(report, notes));
    for (const std::string& note : notes)
        std::fprintf(stderr, "note: %s\n", note.c_str());
    std::printf("%s: %llu triangles, %zu shapes, %zu instances of %zu groups, %zu images, %.1f MB\n",
                out.string().c_str(), static_cast<unsigned long long>(report.triangles), report.shapes,
                report.instances, report.groups, report.images, 1e-6 * static_cast<double>(report.bytes));
}

cli::CommandLine add_convert_command(cli::CommandLine& app, const std::shared_ptr<ConvertArguments>& arguments) {
    cli::CommandLine command =
        app.add_subcommand("convert", "write a scene as Mitsuba 3 XML, with a folder NAME.files of "
                                      "meshes and images beside it");
    command.footer("Example:\n  equistream scene convert scenes/pavilion.json pavilion.xml\n"
                   "  mitsuba -m scalar_rgb -Dspp=16 pavilion.xml");
    command.add_option("SCENE", arguments->scene, "scene description (JSON)").required();
    command.add_option("OUT", arguments->out, "Mitsuba scene to write (.xml)").required();
    cli::add_with_default(command, "--camera", arguments->camera,
                          "perspective (Mitsuba's own, 90 degrees across) or equirect (our plugin)",
                          {"perspective", "equirect"});
    command
        .add_option("--size", arguments->size, "pixels; 1280x720 in perspective and 2048x1024 as a sphere unless given")
        .type_name("WxH");
    command.add_option("--spp", arguments->settings.samples_per_pixel, "samples per pixel")
        .between(1, 1 << 24)
        .with_default();
    command.add_option("--frame", arguments->settings.frame, "frame whose camera and moving objects are written")
        .between(std::int64_t{0}, std::int64_t{1} << 40)
        .with_default();
    command.add_flag("--bake", arguments->settings.bake,
                     "merge objects that stand still into one mesh per material: larger files, but a much faster start "
                     "in Mitsuba's llvm and cuda variants");
    command.add_flag("--overwrite", arguments->settings.overwrite, "replace what an earlier conversion wrote");
    cli::add_json_flag(command, arguments->json);
    return command;
}

std::function<void()> set_up(cli::CommandLine& app, const std::string& command) {
    auto generating = std::make_shared<GenerateArguments>();
    auto informing = std::make_shared<InfoArguments>();
    generating->command = informing->command = command;
    cli::CommandLine generate_command = app.add_subcommand("generate", "make a bundled scene: NAME.glb and NAME.json");
    generate_command.footer("Example:\n  equistream scene generate pavilion --out scenes");
    generate_command.add_option("NAME", generating->name, "which one (--list shows them)");
    generate_command.add_option("--out", generating->folder, "folder to write to, made if need be");
    generate_command
        .add_option("--option", generating->options, "one of the scene's own options; give it again for each")
        .type_name("NAME=VALUE")
        .one_word_each_time();
    generate_command
        .add_option("--knob", generating->knob,
                    "value of the scene's first option (--list shows it), such as wires --knob 0.5")
        .type_name("VALUE");
    generate_command.add_flag("--overwrite", generating->overwrite,
                              "replace a scene that was changed since, or made with other options");
    generate_command.add_flag("--list", generating->list, "list the scenes and their options");
    cli::add_json_flag(generate_command, generating->json);
    cli::CommandLine info_command =
        app.add_subcommand("info", "what a scene holds, its path, and the sizes that the error bound asks for");
    info_command.footer("Example:\n  equistream scene info scenes/pavilion.json");
    info_command
        .add_option("SCENE", informing->scene,
                    "scene description (JSON), or a scene in Mitsuba's XML: lists what must change for Mitsuba 3")
        .required();
    cli::add_json_flag(info_command, informing->json);
    auto describing = std::make_shared<DescribeArguments>();
    describing->command = command;
    cli::CommandLine describe_command = add_describe_command(app, *describing);
    auto converting = std::make_shared<ConvertArguments>();
    converting->command = command;
    cli::CommandLine convert_command = add_convert_command(app, converting);
    auto placing = std::make_shared<std::string>();
    cli::CommandLine placements_command =
        app.add_subcommand("placements", "nodes and instances of a scene's model with their transforms, as JSON");
    placements_command.footer("Example:\n  equistream scene placements scenes/motion.json");
    placements_command.add_option("SCENE", *placing, "scene description (JSON)").required();
    app.require_subcommand();
    return [generating, informing, generate_command, describing, describe_command, converting, convert_command, placing,
            placements_command] {
        if (generate_command.is_chosen())
            generate(*generating);
        else if (describe_command.is_chosen())
            describe(*describing);
        else if (convert_command.is_chosen())
            convert(*converting);
        else if (placements_command.is_chosen())
            placements(*placing);
        else
            info(*informing);
    };
}

}  // namespace
}  // namespace equistream

int main(int argc, char** argv) {
    const std::string command = equistream::cli::quoted_command(argc, argv);
    return equistream::cli::run_program(
        argc, argv,
        {"scene", "Generates bundled scenes, describes models and scenes, converts a scene to Mitsuba XML.",
         "equistream scene generate pavilion --out scenes"},
        [&](equistream::cli::CommandLine& app) { return equistream::set_up(app, command); });
}
