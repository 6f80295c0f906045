/// `equistream model`: a scene's geometry as its client needs it.
#include "figures.h"

#include <equistream/bound.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>
#include <programs/cli/program.h>

#include <unistd.h>

#include <cstdio>

namespace {

using namespace equistream;

struct Arguments {
    model::Request request;
    std::string progress = "auto";
    bool json = false;
};

void require(bool good, const char* option, const char* expected, double found) {
    if (!good)
        throw InputError(expected_found(option, expected, formatted("%g", found)));
}

/// Before minutes of work, not after.
void require_writable(const std::filesystem::path& file) {
    if (file.extension() != ".json")
        throw InputError(
            expected_found("--out", "a file NAME.json (the geometry goes beside it, NAME.glb)", file.string()));
    if (!is_utf8(file.filename().string()))
        throw InputError(expected_found("--out " + file.string(), "a name in UTF-8, as its JSON needs", "other bytes"));
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    std::error_code error;
    if (!std::filesystem::is_directory(folder, error) || access(folder.c_str(), W_OK | X_OK) != 0)
        throw InputError(expected_found("--out " + file.string(), "a folder that can be written to", folder.string()));
}

ClientModelOptions complete(const Arguments& arguments) {
    const model::Request& r = arguments.request;
    require(r.error_px > 0 && r.error_px <= 100, "--error-px", "pixels above 0 and up to 100", r.error_px);
    require(r.focal_px >= 1 && r.focal_px <= 1e6, "--focal", "pixels from 1 to 1e6", r.focal_px);
    require(r.share > 0 && r.share <= 1, "--share", "a part above 0 and up to 1", r.share);
    require(r.quantile > 0 && r.quantile < 1, "--quantile", "a part above 0 and below 1", r.quantile);
    require(r.check_rays >= 10000 && r.check_rays <= (std::int64_t{1} << 30), "--rays", "10000 to 2^30",
            double(r.check_rays));
    require(r.visibility_rays >= 10000 && r.visibility_rays <= (std::int64_t{1} << 36), "--visibility-rays",
            "10000 to 2^36", double(r.visibility_rays));
    require(r.rounds >= 1 && r.rounds <= 100, "--rounds", "1 to 100", r.rounds);
    require(r.ipd_m >= 0 && r.ipd_m <= 1, "--ipd", "metres from 0 to 1", r.ipd_m);
    require_writable(r.out);
    ClientModelOptions options;
    options.silhouette_rad = r.error_px / r.focal_px;
    options.error_rad = options.silhouette_rad * r.share;
    options.ipd_m = r.ipd_m;
    options.visibility_rays = r.visibility_rays;
    options.check_rays = r.check_rays;
    options.kept_quantile = r.quantile;
    options.rounds = r.rounds;
    options.seed = r.seed;
    return options;
}

void run(const Arguments& arguments) {
    const ClientModelOptions options = complete(arguments);
    const model::Request& request = arguments.request;
    const auto start = Clock::now();
    const SceneDescription scene = load_scene(request.scene);
    if (!scene.stands_for.empty())
        throw InputError(expected_found(request.scene.string(), "a scene", "a client's model of one"));
    const SceneModel geometry = load_model(scene, {.shading = false});
    for (const std::string& note : geometry.notes)
        std::fprintf(stderr, "equistream model: %s\n", note.c_str());
    ClientModel built;
    {
        cli::Progress progress("building", 2 + 2 * request.rounds, cli::parse_progress(arguments.progress));
        double steps = 0;
        built = build_client_model(geometry, scene, options,
                                   [&](const std::string& step) { progress.step(++steps, step); });
    }
    if (!built.figures.holds)
        throw WorkError(expected_found(
            request.scene.string(),
            formatted("%g of all rays to keep the bound after %d rounds (--rounds)", request.quantile, request.rounds),
            formatted("%.6f", built.figures.check.kept())));
    write_client_model(request.out, built, scene);
    const model::Figures figures{request, built.figures, seconds_since(start)};
    std::fputs(arguments.json ? figures.json().c_str() : figures.text().c_str(), stdout);
}

std::function<void()> set_up(CLI::App& app, const std::shared_ptr<Arguments>& arguments) {
    model::Request& r = arguments->request;
    app.add_option("SCENE", r.scene, "Scene description (JSON)")->required();
    app.add_option("--out", r.out, "Description to write, NAME.json; NAME.glb is written beside it")->required();
    app.add_option("--error-px", r.error_px,
                   "Whole error budget, in pixels at the centre of a view; edges may shift by it")
        ->capture_default_str();
    app.add_option("--focal", r.focal_px, "That view's focal length, in pixels")->capture_default_str();
    app.add_option("--share", r.share, "Geometry's part of the budget")->capture_default_str();
    app.add_option("--ipd", r.ipd_m, "Distance between the eyes, in metres")->capture_default_str();
    app.add_option("--visibility-rays", r.visibility_rays, "Rays to find out what can be seen")->capture_default_str();
    app.add_option("--rays", r.check_rays, "Rays in each round of checking")->capture_default_str();
    app.add_option("--quantile", r.quantile, "Part of the rays that must keep the bound")->capture_default_str();
    app.add_option("--rounds", r.rounds, "Rounds of checking and restoring, at most")->capture_default_str();
    cli::add_seed_option(app, r.seed, "Of all random rays");
    cli::add_json_flag(app, arguments->json);
    cli::add_progress_option(app, arguments->progress);
    return [arguments] { run(*arguments); };
}

}  // namespace

int main(int argc, char** argv) {
    auto arguments = std::make_shared<Arguments>();
    arguments->request.command = cli::quoted_command(argc, argv);
    return cli::run_program(
        argc, argv,
        {"model",
         "Makes the geometry a client needs: what can be seen from the path's head boxes, simplified "
         "under the error bound and checked by rays.",
         "equistream model scenes/pavilion.json --out pavilion-model.json"},
        [&](CLI::App& app) { return set_up(app, arguments); });
}
