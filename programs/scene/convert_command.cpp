#include "convert_command.h"

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>
#include <scenes/mitsuba/convert.h>

#include <nlohmann/json.hpp>

#include <cstdio>

namespace equistream {
namespace {

struct ConvertArguments {
    std::string scene, out;
    std::string camera = "perspective";
    std::string size;
    bool json = false;
    MitsubaSettings settings;
};

void print_json(const MitsubaReport& report, const std::vector<std::string>& notes) {
    nlohmann::ordered_json json;
    json["triangles"] = report.triangles;
    json["shapes"] = report.shapes;
    json["instances"] = report.instances;
    json["groups"] = report.groups;
    json["images"] = report.images;
    json["bytes"] = report.bytes;
    json["notes"] = notes;
    std::printf("%s\n", json_text(json, 2).c_str());
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
    if (out.extension() != ".xml")
        throw InputError(
            expected_found(arguments.out, "a name that ends in .xml", "'" + out.extension().string() + "'"));
    const SceneDescription scene = load_scene(arguments.scene);
    const SceneModel model = load_model(scene);
    const MitsubaReport report = write_mitsuba_scene(model, scene, out, settings);
    std::vector<std::string> notes = model.notes;
    notes.insert(notes.end(), report.notes.begin(), report.notes.end());
    if (arguments.json)
        return print_json(report, notes);
    for (const std::string& note : notes)
        std::fprintf(stderr, "note: %s\n", note.c_str());
    std::printf("%s: %llu triangles, %zu shapes, %zu instances of %zu groups, %zu images, %.1f MB\n",
                out.string().c_str(), static_cast<unsigned long long>(report.triangles), report.shapes,
                report.instances, report.groups, report.images, 1e-6 * static_cast<double>(report.bytes));
}

}  // namespace

ConvertCommand add_convert_command(CLI::App& app) {
    auto arguments = std::make_shared<ConvertArguments>();
    CLI::App* command = app.add_subcommand("convert", "write a scene as Mitsuba 3 XML, with a folder NAME.files of "
                                                      "meshes and images beside it");
    command->footer("Example:\n  equistream scene convert scenes/pavilion.json pavilion.xml\n"
                    "  mitsuba -m scalar_rgb -Dspp=16 pavilion.xml");
    command->add_option("SCENE", arguments->scene, "scene description (JSON)")->required();
    command->add_option("OUT", arguments->out, "Mitsuba scene to write (.xml)")->required();
    command
        ->add_option("--camera", arguments->camera,
                     "perspective (Mitsuba's own, 90 degrees across) or equirect (our plugin)")
        ->check(CLI::IsMember({"perspective", "equirect"}))
        ->capture_default_str();
    command
        ->add_option("--size", arguments->size,
                     "pixels; 1280x720 in perspective and 2048x1024 as a sphere unless given")
        ->type_name("WxH");
    command->add_option("--spp", arguments->settings.samples_per_pixel, "samples per pixel")
        ->check(CLI::Range(1, 1 << 24))
        ->capture_default_str();
    command->add_option("--frame", arguments->settings.frame, "frame whose camera and moving objects are written")
        ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 40))
        ->capture_default_str();
    command->add_flag(
        "--bake", arguments->settings.bake,
        "no instances of what stands still: more to store, far less to wait for in Mitsuba's llvm and cuda "
        "variants");
    command->add_flag("--overwrite", arguments->settings.overwrite, "replace what an earlier conversion wrote");
    cli::add_json_flag(*command, arguments->json);
    return {command, [arguments] { convert(*arguments); }};
}

}  // namespace equistream
