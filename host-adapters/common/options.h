#pragma once
/// What `equistream render` can be told whatever the host, checked as far as the command line alone allows.
#include <equistream/conventions.h>
#include <equistream/equistream.h>
#include <programs/cli/program.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace equistream::render_command {

struct HostText;

struct RenderOptions {
    std::filesystem::path scene, out, path;  ///< path: empty for the scene's own
    es_camera_kind camera = ES_EQUIRECT;
    std::vector<es_eye> eyes{ES_EYE_CENTRE};
    std::optional<es_eye> small_eye;
    bool layers = false;               ///< the hidden layer too; of one eye only
    bool patches = false;              ///< what eyes of the head box uncover too; of one sphere only
    double patch_budget_percent = 10;  ///< most pixels of theirs, of the sphere's
    int patch_side = 0;                ///< pixels; 0: the smallest whose atlas holds the budget
    es_axis_lock lock = ES_LOCK_WORLD;
    double ipd_m = 0.063;
    std::optional<cli::FrameRange> frames;  ///< none: the whole path
    std::optional<double> frames_per_second;
    cli::Size size;
    double fov_rad = pi / 2;
    LongitudeLatitudeRange range;
    std::uint32_t spp = 64;
    std::uint64_t seed = 1;
    unsigned threads = 0;  ///< 0: one per processor
    std::string aovs = "all";
    bool overwrite = false, single_part = false, json = false;
    bool follow = false;  ///< frames as standard input asks for them
    cli::ProgressStyle progress = cli::ProgressStyle::automatic;
};

/// "centre", "left", "right": also the sub-folders' names.
const char* eye_name(es_eye eye);

/// Adds the options to `app`; after parsing, the returned function gives their checked values.
std::function<RenderOptions()> add_render_options(CLI::App& app, const HostText& host);

}  // namespace equistream::render_command
