#pragma once
/// Which files make a sequence: folders and patterns in, frames out. A frame is one file, or one for each AOV.
#include "channel_map.h"
#include "convert.h"

#include <equistream/denoise_quality.h>
#include <equistream/frame.h>

#include <scenes/library/scene.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace equistream::files {

struct FileSets {
    std::vector<std::string> stems;  ///< what tells the sets apart: "beauty", "depth"; one for each file of a frame
    struct Frame {
        std::int64_t index = 0;
        std::vector<std::filesystem::path> files;  ///< as many as stems
    };
    struct Missing {
        std::int64_t index = 0;
        std::string text;  ///< "frame 7", "frame 12 of depth"
    };
    std::vector<Frame> frames;  ///< ascending
    std::vector<Missing> missing;
};

/// Sources are folders, files, or patterns whose run of # stands for the frame's number. Throws InputError.
FileSets find_files(const std::vector<std::string>& sources);

// A whole import: first a plan, which says what was found, what it is taken for and why; then the frames.

/// What is laid over a preset where an option was given.
struct Overrides {
    std::optional<DepthKind> depth;
    std::optional<double> depth_scale_m, near_plane_m, miss_value, miss_above, forward_at;
    std::optional<MotionConvention> backward, forward;
    std::optional<NormalSpace> normals;
    std::optional<bool> normals_encoded, mirrored, z_up;
    std::map<std::string, std::vector<std::string>> channels;
};

struct ImportSettings {
    std::vector<std::string> sources;
    std::filesystem::path out;
    std::string preset = "auto";
    Overrides overrides;
    std::string camera = "auto";      ///< auto, equirect, ods, perspective
    LongitudeLatitudeRange range;     ///< equirect, ods
    std::optional<double> fov_x_rad;  ///< perspective
    std::string colour_space = "auto";
    std::filesystem::path path;  ///< CSV of the head's poses, in the source's world; empty: attributes
    std::optional<double> frames_per_second;
    std::int64_t first_frame = 0, last_frame = INT64_MAX;
    FrameInfo info;  ///< eye, ipd_m, lock, head_radius_m, exposure, scene
    /// The options of these that were given. Of frames of our own their attributes say the others.
    std::set<std::string> told;
    std::string command;
    bool overwrite = false;
    DenoiseQuality denoise = DenoiseQuality::off;
    /// The pictures show a part of a sphere, for OUT/window (window.h). By itself: their data window of the sphere that
    /// is their display window.
    bool window = false;
    int density = 0;       ///< above 0: they are the windows, of a sphere of so many columns
    WindowPlace corner{};  ///< where their upper left pixel is on that sphere
};

struct Finding {
    std::string found, taken_for, why;
};

struct PlannedView {
    std::string view;  ///< as in the files; empty where they know none
    Eye eye = Eye::centre;
    ChannelMap map;
};

struct ImportPlan {
    FileSets files;  ///< of the frames that were asked for
    /// Where there is no neighbour: frames imported by parts are those of one import.
    std::int64_t first_in_source = 0, last_in_source = 0;
    SourceConventions conventions;
    Camera camera;
    bool ods = false;                   ///< `camera` is a sphere of omnidirectional stereo, of each view's eye
    std::optional<WindowGrid> window;   ///< size of the windows: they are cut out of the pictures
    std::optional<WindowPlace> corner;  ///< the pictures are the windows: where they are
    glm::dmat3 colour_to_rec709{1};
    double frames_per_second = 30;
    FrameInfo shared;                  ///< the settings' info, and what frames of our own say
    bool poses_in_attributes = false;  ///< worldToCamera
    bool poses_of_our_own = false;     ///< the attributes of our own frames
    PosePath path;
    std::string software;
    std::vector<PlannedView> views;
    std::vector<Finding> findings;
    std::vector<std::string> notes;

    std::string table() const;
};

/// Reads the first frame's headers; throws InputError for what cannot be imported.
ImportPlan make_plan(const ImportSettings& settings);

/// Of one view: how many frames were written, and how many were there.
struct ImportedFrames {
    std::filesystem::path folder;
    std::size_t imported = 0, kept = 0;
};

/// Writes OUT/centre, left, right or window. Frames that are there stay, unless `overwrite`. `done` is called after
/// each frame of each view. Throws InputError before the first frame is written, WorkError afterwards.
std::vector<ImportedFrames> run_import(const ImportSettings& settings, ImportPlan& plan,
                                       const std::function<void(std::size_t, std::int64_t)>& done);

}  // namespace equistream::files
