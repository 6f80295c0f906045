#pragma once
/// What a renderer is to `equistream render`. The command asks in the order of RenderHost's functions: describe once,
/// load and begin once, then for each frame that is missing move_to and, for each stream, render. All calls come from
/// one thread. Errors: InputError until rendering has begun, WorkError after.
#include "options.h"
#include "timeline.h"

#include <equistream/patches.h>

#include <nlohmann/json_fwd.hpp>

#include <atomic>
#include <functional>
#include <optional>
#include <span>
#include <string>

namespace equistream::render_command {

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
    std::string aovs;  ///< "none": colour alone is wanted
    std::uint32_t spp = 64;
    es_layer layer = ES_LAYER_FIRST;
    /// Set: an atlas of patches around the sphere that `size` is of; its slots differ from frame to frame.
    std::optional<PatchAtlas> patches{};

    bool wants_geometry() const { return aovs != "none"; }
    std::uint64_t pixels() const {
        return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
    }
};

/// A frame begun through the C ABI, to be filled: by tiles of rays or by whole planes.
struct FrameTask {
    es_frame* frame = nullptr;
    const StreamSettings* stream = nullptr;
    std::int64_t index = 0;
    Pose head_previous, head, head_next;              ///< at the path's ends a neighbour repeats `head`
    const std::atomic<bool>* stop = nullptr;          ///< set: leave the frame unfinished and return
    std::function<void(std::uint64_t)> paths_traced;  ///< called by any thread, now and then
};

/// What decides the pixels besides what the command itself knows of.
struct HostRecord {
    std::string name;      ///< renderer, version and code: frames of another one are not added to
    std::string settings;  ///< such as " bounces 8"; part of the fingerprint
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
    virtual void add_options(CLI::App& app) = 0;
    /// Reads the scene as far as frames' times and poses need it; the host owns what it returns.
    virtual const SceneDescription& describe(const RenderOptions& options) = 0;
    /// Readies the rest. Fingerprints of what describe returned may be filled in only now.
    virtual void load(const RenderOptions& options, const Timeline& timeline) = 0;
    /// Called when the frames in --out, if there are any, are found to be of these settings: from here on files of a
    /// host's own may be put beside them.
    virtual void begin() {}
    /// Pixels that a tile is wide and high at most; 0: as the plugin likes.
    virtual int tile_side() const { return 0; }
    /// False when loading was all that was asked for.
    virtual bool wants_frames() const { return true; }
    virtual HostRecord record() const = 0;
    /// Moves everything to where it is at a frame's time; the neighbours' times are those of motion vectors.
    virtual void move_to(const FrameTimes& times) = 0;
    /// How far rays go, metres, at the time last moved to: +inf for a miss. What patches are planned from.
    virtual void cast(std::span<const es_ray> rays, std::span<float> distances_m) = 0;
    /// Fills the frame, or returns early when told to stop.
    virtual void render(const FrameTask& task) = 0;
    /// Adds to the report's JSON. `render_s` is the time all frames took.
    virtual HostFigures figures(double render_s, nlohmann::json& json) const = 0;
};

}  // namespace equistream::render_command
