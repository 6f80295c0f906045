#include "live_options.h"

#include <equistream/error.h>
#include <equistream/text.h>
#include <programs/cli/hosts.h>
#include <programs/cli/own_folder.h>

#include <algorithm>
#include <string_view>

namespace equistream::serve {

namespace {

constexpr double slowest = 0.01, quickest = 1000;
constexpr std::uint32_t max_samples = 1 << 20;

std::string program_of(const std::string& name) {
    const cli::Host* host = cli::find_host(name);
    if (host == nullptr)
        throw InputError(expected_found("--host", cli::host_names(), "'" + name + "'"));
    const auto program = cli::own_folder() / host->program;
    if (!std::filesystem::exists(program))
        throw InputError(
            expected_found("--host " + name, program.string(), "none; to get it: " + std::string(host->how_to_get_it)));
    return program.string();
}

}  // namespace

bool is_scene(const std::string& source) {
    return source.ends_with(".json") || source.ends_with(".xml");
}

void add_live_options(CLI::App& app, LiveOptions& o) {
    const std::string group = "For a scene, rendered while it is watched";
    const auto add = [&](const char* name, auto& value, const std::string& text) {
        return app.add_option(name, value, text)->group(group);
    };
    add("--host", o.host, "Renderer: " + cli::host_names())->capture_default_str();
    add("--size", o.size, "Of the spheres, WxH")->capture_default_str();
    add("--spp", o.spp, "Samples per pixel, at most: fewer where that keeps up with --rate")->capture_default_str();
    add("--rate", o.rate, "Spheres a second to keep up with; more where there is time")->capture_default_str();
    add("--path", o.path, "Path (CSV) of the head until a viewer moves, instead of the scene's");
    add("--threads", o.threads, "Rendering threads (default: one per processor)");
    add("--depth", o.depth, "auto, or none: no track of depth")->capture_default_str();
    add("--crf", o.coding.crf, "Quality: 0 (best) to 51")->capture_default_str();
    add("--preset", o.coding.preset, "The encoder's, as in encode")->capture_default_str();
    add("--out", o.coding.out, "File (.mkv) that gets the bytes of a viewer that is there from the beginning");
}

void require_live_options_unused(const CLI::App& app, const std::string& source) {
    for (const char* name :
         {"--host", "--size", "--spp", "--rate", "--path", "--threads", "--depth", "--crf", "--preset", "--out"})
        if (app.count(name) > 0)
            throw InputError(
                expected_found(std::string(name) + ": " + source, "a scene (.json, .xml) to render", "none"));
}

LiveSettings live_settings(const LiveOptions& options, const std::string& scene, const std::filesystem::path& folder,
                           const std::vector<std::string>& more) {
    const cli::Size size = cli::parse_size(options.size);
    if (size.width % 2 != 0 || size.height % 2 != 0 || std::min(size.width, size.height) < min_track_side)
        throw InputError(
            expected_found("--size", "even sides of at least " + std::to_string(min_track_side), options.size));
    if (options.spp < 1 || options.spp > max_samples)
        throw InputError(expected_found("--spp", "1 to 1048576", std::to_string(options.spp)));
    if (!(options.rate >= slowest && options.rate <= quickest))
        throw InputError(expected_found("--rate", "0.01 to 1000", in_words(options.rate)));
    if (options.depth != "auto" && options.depth != "none")
        throw InputError(expected_found("--depth", "auto or none", "'" + options.depth + "'"));
    if (!options.coding.out.empty() && !options.coding.out.ends_with(".mkv"))
        throw InputError(expected_found("--out", "a name ending in .mkv", "'" + options.coding.out + "'"));
    StreamSettings coding;
    coding.crf = options.coding.crf;
    coding.preset = options.coding.preset;
    check_coding(coding, "--");
    LiveSettings settings;
    settings.program = program_of(options.host);
    settings.arguments = {scene,        "--follow",   "--out",  (folder / "frames").string(),
                          "--size",     options.size, "--aovs", options.depth == "none" ? "none" : "depth",
                          "--progress", "none"};
    if (!options.path.empty())
        settings.arguments.insert(settings.arguments.end(), {"--path", options.path});
    if (options.threads > 0)
        settings.arguments.insert(settings.arguments.end(), {"--threads", std::to_string(options.threads)});
    settings.arguments.insert(settings.arguments.end(), more.begin(), more.end());
    settings.max_spp = options.spp;
    settings.spheres_per_s = options.rate;
    settings.coding = options.coding;
    settings.coding.depth = options.depth != "none";
    return settings;
}

}  // namespace equistream::serve
