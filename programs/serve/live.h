#pragma once
/// A scene rendered while it is watched: a renderer as a child, an encoder in a thread, a stream for all viewers.
#include "live_encoder.h"
#include "pace.h"
#include "server.h"
#include "stage_times.h"

#include <programs/cli/program.h>

#include <asio/signal_set.hpp>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace equistream::serve {

struct LiveSettings {
    std::string program;                 ///< of the host
    std::vector<std::string> arguments;  ///< of it, --follow among them
    std::uint32_t max_spp = 16;
    double spheres_per_s = 2;  ///< to be kept up with fewer samples, where need be
    bool has_window = false;
    std::optional<double> max_mbps;  ///< megabits a second that the stream may take; nothing: what the line carries
    LiveCoding coding;
    ServerSettings server;
};

/// Times are means, of spheres that followed one another without a pause.
struct LiveFigures {
    std::int64_t spheres = 0;
    double spheres_per_s = 0;
    Samples samples;  ///< at the end
    double render_s = 0, write_s = 0, encode_s = 0;
    double crf = 0;            ///< at the end, the window's where there is one
    double window_pixels = 1;  ///< at the end, over those at first
    double coded_mbps = 0;     ///< megabits a second as coded, on average
    std::int64_t missed = 0;   ///< spheres that viewers behind passed over
    double age_s = 0;          ///< from when a sphere's place was taken to when its bytes could be sent
    StageTimes stages;
    std::int64_t poses = 0;
    ServerFigures server;
};

/// Until a signal of `stop` comes; whoever watches gets what there is and the stream's end. Calls `listening` once
/// viewers may come, with where browsers go (empty: nowhere). Throws what ended the renderer, where it was not asked to
/// end, in the same order.
LiveFigures serve_live(asio::io_context& io, asio::signal_set& stop, std::unique_ptr<Door> door,
                       const LiveSettings& settings, const std::function<void(const std::string& web_url)>& listening);

// What `equistream serve SCENE` is told beyond what every server is.

struct LiveOptions {
    std::string host = "embree", size = "480x240", path, window, depth = "auto", denoise = "off";
    std::optional<int> density;  ///< none: the renderer's own choice
    unsigned threads = 0;
    std::uint32_t accumulate = 0;
    LiveSettings settings;  ///< all but the program and its arguments, and whether there is depth
};

/// Whether a source is a scene rather than something rendered: by its name.
bool is_scene(const std::string& source);

void add_live_options(cli::CommandLine& app, LiveOptions& options);
/// Throws InputError where one of them was given for what is no scene.
void require_live_options_unused(const cli::CommandLine& app, const std::string& source);

/// `folder` is for the renderer's frames, `more` are arguments of its own. Throws InputError naming what cannot be.
LiveSettings live_settings(const LiveOptions& options, const std::string& scene, const std::filesystem::path& folder,
                           const std::vector<std::string>& more);

}  // namespace equistream::serve
