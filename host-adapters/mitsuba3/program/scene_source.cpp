#include "scene_source.h"

#include "mitsuba_scenes.h"

#include <equistream/error.h>

namespace equistream::mitsuba_host {

std::unique_ptr<SceneSource> open_scene(const LoadContext& context) {
    if (context.options.scene.extension() == ".xml")
        return std::make_unique<XmlScene>(context);
    return std::make_unique<OwnScene>(context);
}

namespace {

constexpr const char* xml_options[] = {"--define", "--sensor", "--up", "--unit-m", "--lean", "--scene-only"};

}  // namespace

std::vector<std::pair<std::string, std::string>> HostOptions::parameters() const {
    std::vector<std::pair<std::string, std::string>> pairs;
    for (const std::string& definition : definitions) {
        const std::size_t at = definition.find('=');
        if (at == 0 || at == std::string::npos)
            throw InputError(expected_found("-D", "name=value", "'" + definition + "'"));
        pairs.emplace_back(definition.substr(0, at), definition.substr(at + 1));
    }
    return pairs;
}

void add_host_options(cli::CommandLine& app, HostOptions& o) {
    app.add_option("--variant", o.variant,
                   "Mitsuba's variant (default: llvm_ad_rgb where LLVM loads, else scalar_rgb)");
    app.add_option("--max-bounces", o.max_bounces, "Scatterings of a path at most (default: 8; of XML: its own)")
        .between(0u, 65535u);
    const std::string group = "For XML";
    app.add_option("-D,--define", o.definitions, "name=value: the value of $name in the XML")
        .one_word_each_time()
        .type_name("NAME=VALUE")
        .group(group);
    app.add_option("--sensor", o.sensor, "Which of the XML's sensors the head begins at")
        .between(0, 65535)
        .with_default()
        .group(group);
    app.add_option("--up", o.up, "The XML's axis that becomes +Y; auto: the one nearest to the sensor's up")
        .one_of({"auto", "x", "y", "z", "-x", "-y", "-z"})
        .with_default()
        .group(group);
    app.add_option("--unit-m", o.unit_m, "Metres in one unit of the XML")
        .between(1e-9, 1e9)
        .with_default()
        .group(group);
    app.add_option("--lean", o.head_radius_m, "Metres the head may move off the path, for the exported geometry")
        .between(0.0, 1e6)
        .with_default()
        .group(group);
    app.add_flag("--scene-only", o.scene_only, "Write scene.glb and scene.json, and render nothing").group(group);
}

void require_xml_options_unused(const cli::CommandLine& app) {
    for (const char* name : xml_options)
        if (app.is_given(name))
            throw InputError(expected_found(name, "a scene in Mitsuba's XML", "a scene description"));
}

}  // namespace equistream::mitsuba_host
