#pragma once
/// What `equistream render` is told whatever the host, and what a host has to offer it. Also the program around a host.
#include <equistream/conventions.h>
#include <equistream/equistream.h>
#include <equistream/frame_part.h>
#include <equistream/patches.h>
#include <equistream/window.h>

#include <programs/cli/program.h>
#include <scenes/library/scene.h>

#include <nlohmann/json_fwd.hpp>

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream::render_command {

struct HostText;

/// Part of a denser sphere that is rendered as well; the whole sphere is its base.
struct WindowOptions {
    WindowGrid grid;
    bool follows_gaze = false;    ///< the head's; else it stays
    glm::dvec3 middle{0, 0, -1};  ///< where it stays, in the sphere's axes
};

struct RenderOptions {
    std::filesystem::path scene, out, path;  ///< path: empty for the scene's own
    es_camera_kind camera = ES_EQUIRECT;
    std::vector<es_eye> eyes{ES_EYE_CENTRE};
    std::optional<es_eye> small_eye;
    bool layers = false;                  ///< the hidden layer too; of one eye only
    bool patches = false;                 ///< what eyes of the head box uncover too; of one sphere only
    double patch_budget_percent = 10;     ///< most pixels of theirs, of the sphere's
    int patch_side = 0;                   ///< pixels; 0: the smallest whose atlas holds the budget
    std::optional<WindowOptions> window;  ///< of one whole sphere only
    es_axis_lock lock = ES_LOCK_WORLD;
    double ipd_m = 0.063;
    std::optional<cli::FrameRange> frames;  ///< none: the whole path
    std::optional<double> frames_per_second;
    cli::Size size;
    double fov_rad = pi / 2;
    LongitudeLatitudeRange range;
    std::uint32_t spp = 64;
    bool samples_by_angle = false;  ///< fewer where pixels span less; else as many everywhere
    std::uint64_t seed = 1;
    unsigned threads = 0;  ///< 0: one per processor
    std::string aovs = "all";
    es_denoise denoise = ES_DENOISE_OFF;
    std::uint32_t accumulate = 0;  ///< earlier frames that count at most where anything moves; 0: none
    bool overwrite = false, single_part = false, json = false;
    bool follow = false;   ///< frames as standard input asks for them
    bool dry_run = false;  ///< nothing is rendered
    FramePart part;        ///< of each frame
    cli::ProgressStyle progress = cli::ProgressStyle::automatic;
};

/// "centre", "left", "right": also the sub-folders' names.
const char* eye_name(es_eye eye);

/// The window's grid, and those of fewer pixels that orders may ask for (--follow): each has half the pixels of the one
/// before (halved_window_grid), is denser than the sphere around it, and is no smaller than video may be. Empty without
/// a window.
std::vector<WindowGrid> window_grids(const RenderOptions& options);

/// Adds the options to `app`; after parsing, the returned function gives their checked values.
std::function<RenderOptions()> add_render_options(cli::CommandLine& app, const HostText& host);

// Which frames there are to make, and at what times.

/// Beyond the path's ends there is nothing: a neighbour is the frame itself.
struct FrameTimes {
    std::int64_t index = 0;
    double previous_s = 0, now_s = 0, next_s = 0;
};

struct Timeline {
    PosePath path;
    double frames_per_second = 30;
    std::int64_t path_frames = 1;
    cli::FrameRange range;

    FrameTimes times(std::int64_t index) const;
    double time_s(std::int64_t index) const { return static_cast<double>(index) / frames_per_second; }
};

/// Throws InputError where there is no path, or --frames leaves it.
Timeline make_timeline(const RenderOptions& options, const SceneDescription& scene);

// What a renderer is to `equistream render`. The command asks in the order of RenderHost's functions: describe once,
// load and begin once, then for each frame that is missing move_to and, for each stream, render. All calls come from
// one thread. Errors: InputError until rendering has begun, WorkError after.

/// What --help says of a host.
struct HostText {
    std::string name;  ///< as --host takes it
    std::string summary, example;
    std::string scene;  ///< what the argument SCENE is
};

/// One sequence that a render writes: a sub-folder of --out.
struct StreamSettings {
    std::string name;  ///< sub-folder
    es_eye eye = ES_EYE_CENTRE;
    cli::Size size;
    std::string aovs;        ///< what a host answers; "none": colour alone
    std::uint32_t spp = 64;  ///< of every frame, where they are not accumulated
    es_layer layer = ES_LAYER_FIRST;
    /// Set: an atlas of patches around the sphere that `size` is of; its slots differ from frame to frame.
    std::optional<PatchAtlas> patches{};
    bool denoised = false;
    bool accumulates = false;            ///< frames carry light on to the next
    int tile_side = 0;                   ///< 0: as the plugin likes
    std::optional<WindowGrid> window{};  ///< set: windows, of this size
    bool is_base = false;                ///< shows what the window does, where that is

    bool wants_geometry() const { return aovs != "none"; }
    /// Whether the plugin takes a denoiser's guides.
    bool wants_guides() const;
    /// Whether it takes what each colour sample met (es_tile_put_ids).
    bool wants_ids() const;
    std::uint64_t pixels() const {
        return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
    }
};

/// A frame begun through the C ABI, to be filled: by tiles of rays or by whole planes.
struct FrameTask {
    es_frame* frame = nullptr;
    const StreamSettings* stream = nullptr;
    std::int64_t index = 0;
    std::uint32_t spp = 64;                           ///< samples a pixel; tiles know their own
    std::uint32_t previous_frames = 1;                ///< how many frames ago head_previous is
    WindowPlace window_place{};                       ///< of a stream of windows
    Pose head_previous, head, head_next;              ///< at the path's ends a neighbour repeats `head`
    const std::atomic<bool>* stop = nullptr;          ///< set: leave the frame unfinished and return
    std::function<void(std::uint64_t)> paths_traced;  ///< called by any thread, now and then
};

/// What decides the pixels besides what the command itself knows of.
struct HostRecord {
    std::string name;      ///< renderer, version and code: frames of another one are not added to
    std::string settings;  ///< such as " bounces 8"; part of the fingerprint
};

/// What Cryptomatte calls objects and materials, by their ids less 1. Of none and of empty ones the number is taken.
struct HostNames {
    std::vector<std::string> objects, materials;
};

/// What a host adds to the report.
struct HostFigures {
    std::string loaded;  ///< such as "BVH 0.1 s (12 MiB)"
    std::string rates;   ///< such as "3.2 M rays/s"; may be empty
    std::uint64_t left_out_samples = 0;
};

class RenderHost {
public:
    virtual ~RenderHost() = default;
    virtual HostText text() const = 0;
    /// Adds what this renderer alone has; values are read when describe is called.
    virtual void add_options(cli::CommandLine& app) = 0;
    /// Reads the scene as far as frames' times and poses need it; the host owns what it returns.
    virtual const SceneDescription& describe(const RenderOptions& options) = 0;
    /// Readies the rest. Fingerprints of what describe returned may be filled in only now.
    virtual void load(const RenderOptions& options, const Timeline& timeline) = 0;
    /// Called when the frames in --out, if there are any, are found to be of these settings: from here on files of a
    /// host's own may be put beside them.
    virtual void begin() {}
    /// Pixels that a tile is wide and high at most; 0: as the plugin likes.
    virtual int tile_side() const { return 0; }
    /// Whether spheres are filled by tiles of rays, so that tiles without colour passes cost nothing.
    virtual bool fills_tiles() const { return true; }
    /// False when loading was all that was asked for.
    virtual bool wants_frames() const { return true; }
    virtual HostRecord record() const = 0;
    /// Once it is loaded.
    virtual HostNames names() const { return {}; }
    /// Moves everything to where it is at a frame's time; the neighbours' times are those of motion vectors.
    virtual void move_to(const FrameTimes& times) = 0;
    /// How far rays go, metres, at the time last moved to: +inf for a miss. What patches are planned from.
    virtual void cast(std::span<const es_ray> rays, std::span<float> distances_m) = 0;
    /// Fills the frame, or returns early when told to stop.
    virtual void render(const FrameTask& task) = 0;
    /// Adds to the report's JSON. `render_s` is the time all frames took.
    virtual HostFigures figures(double render_s, nlohmann::json& json) const = 0;
};

/// The whole of `equistream render` around one host: parses, loads, renders every frame that is not there yet, reports;
/// returns the exit status. An interrupt (SIGINT, SIGTERM) leaves whole frames only and ends in an error that says how
/// many.
int run(int argc, char** argv, RenderHost& host);

}  // namespace equistream::render_command

// Which code this program was built from.

namespace equistream {

/// Eight hexadecimal digits over the sources that decide pixels, as each host lists them
/// (cmake/CodeIdentity.cmake).
const char* code_identity();

}  // namespace equistream
