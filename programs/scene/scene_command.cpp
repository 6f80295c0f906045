/// equistream scene: generate NAME --out DIR, info SCENE, placements SCENE, convert SCENE OUT.
#include "convert_command.h"
#include "summary.h"

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <programs/cli/program.h>
#include <scenes/generate/generate.h>
#include <scenes/mitsuba/old_scene.h>

#include <cstdio>

namespace equistream {
namespace {

struct GenerateArguments {
    std::string name;
    std::string folder;
    std::vector<std::string> options;
    std::string knob;
    bool list = false;
};

struct InfoArguments {
    std::string scene;
    bool json = false;
};

void print(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
}

void list_generators() {
    for (const Generator& generator : generators()) {
        std::printf("%-12.*s%.*s\n", static_cast<int>(generator.name.size()), generator.name.data(),
                    static_cast<int>(generator.summary.size()), generator.summary.data());
        for (const GeneratorOption& option : generator.options)
            print("              --option " + std::string(option.name) + "=" + std::string(option.default_value) +
                  ": " + std::string(option.meaning) + "\n");
    }
}

void generate(const GenerateArguments& arguments) {
    if (arguments.list)
        return list_generators();
    if (arguments.name.empty() || arguments.folder.empty())
        throw InputError("generate: expected a scene's name and --out DIR (--list shows the names)");
    const Generator& generator = find_generator(arguments.name);
    std::vector<std::string> settings = arguments.options;
    if (!arguments.knob.empty()) {
        if (generator.options.empty())
            throw InputError(expected_found("--knob", "a scene with options", arguments.name + ", which has none"));
        settings.push_back(std::string(generator.options.front().name) + "=" + arguments.knob);
    }
    const GeneratedScene scene = make_scene(generator, settings);
    const std::filesystem::path description = write_scene(scene, arguments.folder);
    print(description.string() + ": " + std::to_string(scene.model.triangle_count()) + " triangles\n");
}

/// Of a scene in Mitsuba's XML: what keeps Mitsuba 3 from reading it.
void info_of_xml(const InfoArguments& arguments) {
    const std::vector<std::string> changes = mitsuba_xml::changes_for_mitsuba3(arguments.scene);
    if (arguments.json)
        return print(json_text(nlohmann::json{{"must_change", changes}}, 2) + "\n");
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
    print(arguments.json ? summary_json(summary) : summary_text(summary));
}

void placements(const std::string& scene) {
    print(placements_json(load_model(load_scene(scene))));
}

std::function<void()> set_up(CLI::App& app) {
    auto generating = std::make_shared<GenerateArguments>();
    auto informing = std::make_shared<InfoArguments>();
    CLI::App* generate_command = app.add_subcommand("generate", "make a bundled scene: NAME.glb and NAME.json");
    generate_command->footer("Example:\n  equistream scene generate pavilion --out scenes");
    generate_command->add_option("NAME", generating->name, "which one (--list shows them)");
    generate_command->add_option("--out", generating->folder, "folder to write to, made if need be");
    generate_command->add_option("--option", generating->options, "one of the scene's own options, NAME=VALUE")
        ->type_name("NAME=VALUE");
    generate_command
        ->add_option("--knob", generating->knob,
                     "value of the scene's first option (--list shows it), such as wires --knob 0.5")
        ->type_name("VALUE");
    generate_command->add_flag("--list", generating->list, "list the scenes and their options");
    CLI::App* info_command = app.add_subcommand("info", "what a scene holds, its path, and what the bound asks of it");
    info_command->footer("Example:\n  equistream scene info scenes/pavilion.json");
    info_command
        ->add_option("SCENE", informing->scene,
                     "scene description (JSON), or a scene in Mitsuba's XML: what of Mitsuba 0.6 must change in it")
        ->required();
    cli::add_json_flag(*info_command, informing->json);
    const ConvertCommand converting = add_convert_command(app);
    auto placing = std::make_shared<std::string>();
    CLI::App* placements_command =
        app.add_subcommand("placements", "nodes and instances of a scene's model with their transforms, as JSON");
    placements_command->footer("Example:\n  equistream scene placements scenes/motion.json");
    placements_command->add_option("SCENE", *placing, "scene description (JSON)")->required();
    app.require_subcommand(1);
    return [generating, informing, generate_command, converting, placing, placements_command] {
        if (generate_command->parsed())
            generate(*generating);
        else if (converting.app->parsed())
            converting.run();
        else if (placements_command->parsed())
            placements(*placing);
        else
            info(*informing);
    };
}

}  // namespace
}  // namespace equistream

int main(int argc, char** argv) {
    return equistream::cli::run_program(argc, argv,
                                        {"scene",
                                         "Generates bundled scenes, describes any scene, converts one to Mitsuba XML.",
                                         "equistream scene generate pavilion --out scenes"},
                                        equistream::set_up);
}
