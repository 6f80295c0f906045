/// `equistream model`: a scene's geometry as its client needs it.
#include <client/model/client_model.h>
#include <equistream/bound.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/locks.h>
#include <equistream/text.h>
#include <programs/cli/paths.h>
#include <programs/cli/process.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <memory>

namespace {

using namespace equistream;

/// A model as coarse as this was as good as all geometry in five scenes (docs/decisions/0016).
constexpr double default_model_error_px = 4;

struct Arguments {
    std::string command, progress = "auto";
    std::filesystem::path scene, out;
    double error_px = default_model_error_px;
    double focal_px = default_focal_length_px;
    double share = default_budget_share;
    ClientModelOptions options;  ///< all but what comes of the figures above
    bool json = false;
};

void require(bool good, const char* option, const char* expected, double found) {
    cli::require(good, option, expected, formatted("%g", found));
}

/// Before minutes of work, not after.
void require_writable(const std::filesystem::path& file) {
    cli::require(file.extension() == ".json", "--out", "a file NAME.json (the geometry goes beside it, NAME.glb)",
                 file.string());
    cli::require(is_utf8(file.filename().string()), "--out " + file.string(), "a name in UTF-8, as its JSON needs",
                 "other bytes");
    cli::require_writable_file(file);
}

std::filesystem::path geometry_beside(std::filesystem::path description) {
    return description.replace_extension(".glb");
}

bool describes_client_model(const std::filesystem::path& file) {
    std::ifstream text(file);
    const nlohmann::json description = nlohmann::json::parse(text, nullptr, false);
    return description.is_object() && description.contains("stands_for");
}

/// Neither what is read here nor another scene makes way: an earlier model of a client's alone does.
void require_replaceable(const std::filesystem::path& file, const SceneDescription& scene) {
    const std::filesystem::path geometry = geometry_beside(file);
    for (const std::filesystem::path& target : {file, geometry})
        cli::require_not_read("--out", target, {scene.file, scene.model});
    std::error_code error;
    for (const std::filesystem::path& target : {file, geometry})
        cli::require(!std::filesystem::exists(target, error) || describes_client_model(file) ||
                         describes_client_model(unfinished_description(file)),
                     "--out " + file.string(), "a new name, or a client's model to replace", target.string());
}

/// Keeps the name for one run, from before its work on. What it leaves unfinished is empty, and goes with it.
class OutputName {
public:
    explicit OutputName(const std::filesystem::path& file)
        : unfinished_(unfinished_description(file)), descriptor_(open_locked_file(unfinished_)) {
        const bool is_locked = descriptor_ < 0 && errno == EWOULDBLOCK;
        cli::require(!is_locked, "--out " + file.string(), "a file that no other process is writing",
                     unfinished_.string() + ", which another process is writing");
        const bool is_no_file = descriptor_ < 0 && (errno == ELOOP || errno == EINVAL || errno == ENXIO);
        cli::require(!is_no_file, "--out " + file.string(), "a place for its unfinished file",
                     lock_problem(unfinished_, errno));
    }
    ~OutputName() {
        if (descriptor_ < 0)
            return;
        std::error_code ignored;
        if (is_still_named(descriptor_, unfinished_) && std::filesystem::file_size(unfinished_, ignored) == 0)
            std::filesystem::remove(unfinished_, ignored);
        close(descriptor_);
    }
    OutputName(const OutputName&) = delete;
    OutputName& operator=(const OutputName&) = delete;

private:
    std::filesystem::path unfinished_;
    int descriptor_;
};

ClientModelOptions complete(const Arguments& r) {
    ClientModelOptions options = r.options;
    require(r.error_px > 0 && r.error_px <= 100, "--error-px", "pixels above 0 and up to 100", r.error_px);
    require(r.focal_px >= 1 && r.focal_px <= 1e6, "--focal", "pixels from 1 to 1e6", r.focal_px);
    require(r.share > 0 && r.share <= 1, "--share", "a part above 0 and up to 1", r.share);
    require(options.kept_quantile > 0 && options.kept_quantile < 1, "--quantile", "a part above 0 and below 1",
            options.kept_quantile);
    require(options.check_rays >= 10000 && options.check_rays <= (std::int64_t{1} << 30), "--rays", "10000 to 2^30",
            double(options.check_rays));
    require(options.visibility_rays >= 10000 && options.visibility_rays <= (std::int64_t{1} << 36), "--visibility-rays",
            "10000 to 2^36", double(options.visibility_rays));
    require(options.rounds >= 1 && options.rounds <= 100, "--rounds", "1 to 100", options.rounds);
    require(options.ipd_m >= 0 && options.ipd_m <= 1, "--ipd", "metres from 0 to 1", options.ipd_m);
    require_writable(r.out);
    options.silhouette_rad = r.error_px / r.focal_px;
    options.error_rad = options.silhouette_rad * r.share;
    return options;
}

/// Of the geometry beside the description.
std::uintmax_t bytes_beside(const std::filesystem::path& description) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(geometry_beside(description), error);
    return error ? 0 : bytes;
}

nlohmann::ordered_json quantiles(const std::array<double, 4>& rad, double focal_px) {
    return {{"p50", rad[0] * focal_px},
            {"p99", rad[1] * focal_px},
            {"p99.9", rad[2] * focal_px},
            {"p99.99", rad[3] * focal_px}};
}

/// `seconds`: loading and writing included.
std::string json_of(const Arguments& request, const ClientModelFigures& of_model, double seconds) {
    const RayCheck& c = of_model.check;
    nlohmann::ordered_json json = cli::provenance(request.command);
    json["scene"] = request.scene.string();
    json["model"] = request.out.string();
    json["error_px"] = request.error_px;
    json["share"] = request.share;
    json["focal_px"] = request.focal_px;
    json["seed"] = request.options.seed;
    json["box_radius_m"] = of_model.box_radius_m;
    json["path"] = {{"centres", of_model.centres}, {"cell_m", of_model.cell_m}, {"added_m", of_model.added_m}};
    json["triangles"] = {{"before", of_model.triangles_before},
                         {"seen", of_model.triangles_seen},
                         {"after", of_model.triangles_after},
                         {"unique_before", of_model.unique_before},
                         {"unique_after", of_model.unique_after}};
    json["bytes"] = bytes_beside(request.out);
    json["seconds"] = {{"all", seconds},
                       {"visibility", of_model.visibility_s},
                       {"simplify", of_model.simplify_s},
                       {"check", of_model.check_s}};
    json["rounds"] = of_model.rounds;
    json["check"] = {{"rays", c.rays},
                     {"kept", c.kept()},
                     {"within", c.within},
                     {"at_edges", c.at_edges},
                     {"failing", c.failing},
                     {"displacement_px", quantiles(c.displacement_rad, request.focal_px)},
                     {"edge_shift_px", quantiles(c.edge_shift_rad, request.focal_px)}};
    return json_text(json, 2) + "\n";
}

std::string text_of(const Arguments& request, const ClientModelFigures& of_model, double seconds) {
    const RayCheck& c = of_model.check;
    const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
    const double f = request.focal_px;
    std::string out = formatted("%s: %llu of %llu triangles (%.1f %%), %.2f MB\n", request.out.string().c_str(),
                                number(of_model.triangles_after), number(of_model.triangles_before),
                                100 * double(of_model.triangles_after) / double(of_model.triangles_before),
                                1e-6 * double(bytes_beside(request.out)));
    out += formatted("visible from the path: %llu triangles\n", number(of_model.triangles_seen));
    if (of_model.added_m > 0)
        out += formatted("long path: approximated by %llu cells of %.2f m, with head boxes %.2f m larger\n",
                         number(of_model.centres), of_model.cell_m, of_model.added_m);
    out += formatted(
        "rays checked: %lld in the last of %d rounds; %.4f %% are within the bound of %g px, %.4f %% more at edges\n",
        static_cast<long long>(c.rays), of_model.rounds, 100 * double(c.within) / double(c.rays),
        request.error_px * request.share, 100 * double(c.at_edges) / double(c.rays));
    out += formatted("displacement, px: %.4f (median), %.4f (99 %%), %.4f (99.9 %%), %.4f (99.99 %%)\n",
                     f * c.displacement_rad[0], f * c.displacement_rad[1], f * c.displacement_rad[2],
                     f * c.displacement_rad[3]);
    out += formatted("shift of edges, px: at most %.3f (median of those rays), %.3f (99 %%)\n", f * c.edge_shift_rad[0],
                     f * c.edge_shift_rad[1]);
    out += formatted("seconds: %.1f (visibility %.1f, simplifying %.1f, checking %.1f)\n", seconds,
                     of_model.visibility_s, of_model.simplify_s, of_model.check_s);
    return out;
}

void run(const Arguments& request) {
    const ClientModelOptions options = complete(request);
    const std::string at_interrupt =
        "equistream model: interrupted: " + request.out.string() + " is not finished; the same command starts over";
    cli::say_at_interrupt(at_interrupt);
    const auto start = Clock::now();
    const SceneDescription scene = load_scene(request.scene);
    cli::require(scene.stands_for.empty(), request.scene.string(), "a scene", "a client's model of one");
    require_replaceable(request.out, scene);
    const OutputName name(request.out);
    cli::say_at_interrupt(at_interrupt, unfinished_description(request.out));
    description_text(scene);  // refused before the work, where paths have too many keys for it
    const SceneModel geometry = load_model(scene, {.shading = false});
    for (const std::string& note : geometry.notes)
        std::fprintf(stderr, "equistream model: %s\n", note.c_str());
    ClientModel built;
    {
        cli::Progress progress("building", 2 + 2 * options.rounds, cli::parse_progress(request.progress));
        double steps = 0;
        built = build_client_model(geometry, scene, options,
                                   [&](const std::string& step) { progress.step(++steps, step); });
    }
    if (!built.figures.holds)
        throw WorkError(expected_found(request.scene.string(),
                                       formatted("%g of all rays within the bound after %d rounds (raise --rounds)",
                                                 options.kept_quantile, options.rounds),
                                       formatted("%.6f", built.figures.check.kept())));
    write_client_model(request.out, built, scene);
    const auto report = request.json ? json_of : text_of;
    std::fputs(report(request, built.figures, seconds_since(start)).c_str(), stdout);
}

std::function<void()> set_up(cli::CommandLine& app, const std::shared_ptr<Arguments>& arguments) {
    Arguments& r = *arguments;
    app.add_option("SCENE", r.scene, "Scene description (JSON)").required();
    app.add_option("--out", r.out, "Description to write, NAME.json; NAME.glb is written beside it").required();
    cli::add_with_default(app, "--error-px", r.error_px,
                          "Whole error budget, in pixels at the centre of a view; edges may shift by it");
    cli::add_with_default(app, "--focal", r.focal_px, "That view's focal length, in pixels");
    cli::add_with_default(app, "--share", r.share, "Geometry's part of the budget");
    cli::add_with_default(app, "--ipd", r.options.ipd_m, "Distance between the eyes, in metres");
    cli::add_with_default(app, "--visibility-rays", r.options.visibility_rays, "Rays to find out what can be seen");
    cli::add_with_default(app, "--rays", r.options.check_rays, "Rays in each round of checking");
    cli::add_with_default(app, "--quantile", r.options.kept_quantile,
                          "Share of the rays that must stay within the bound");
    cli::add_with_default(app, "--rounds", r.options.rounds, "Rounds of checking and restoring, at most");
    cli::add_seed_option(app, r.options.seed, "Of all random rays");
    cli::add_json_flag(app, r.json);
    cli::add_progress_option(app, r.progress);
    return [arguments] { run(*arguments); };
}

}  // namespace

int main(int argc, char** argv) {
    auto arguments = std::make_shared<Arguments>();
    arguments->command = cli::quoted_command(argc, argv);
    return cli::run_program(
        argc, argv,
        {"model",
         "Makes the geometry a client needs: what can be seen from the path's head boxes, simplified "
         "under the error bound and checked by rays.",
         "equistream model scenes/pavilion.json --out pavilion-model.json"},
        [&](equistream::cli::CommandLine& app) { return set_up(app, arguments); });
}
