#pragma once
/// What `equistream play` was asked to do.
#include <client/fill/fill.h>
#include <client/reflections/specular.h>
#include <client/timing/delivery_simulator.h>
#include <client/view/stereo_layout.h>
#include <equistream/colour.h>
#include <equistream/object_motion.h>
#include <programs/cli/program.h>
#include <scenes/library/scene.h>

#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace equistream::play {

enum class Format { png, exr, mp4 };
inline constexpr std::array format_names = {"png", "exr", "mp4"};
enum class Layout { files, side_by_side, anaglyph };
inline constexpr std::array layout_names = {"files", "sbs", "anaglyph"};

struct Settings {
    std::string command;
    std::string source;  ///< file, URL or folder
    std::filesystem::path
        scene;  ///< description whose geometry gives depth; of a scene, or (--model) of a client's model
    bool scene_is_model = false;  ///< it came by --model
    std::filesystem::path head;
    std::string method;             ///< empty: by what depth there is (choose_depth); auto: what `budget_ms` allows
    double budget_ms = 0;           ///< a frame, both eyes, decoding to filling; for auto
    bool rechoose = true;           ///< auto: chosen again while playing
    std::string depth;              ///< as in --depth; empty: the first there is of ray and what came
    std::optional<cli::Size> size;  ///< nothing: the source's for perspective pictures, else default_size
    std::optional<double> fov_deg;  ///< nothing: the source's for perspective pictures, else 90
    std::optional<double> ipd_m;    ///< nothing: the one each picture is tagged with
    std::string fill = default_fill;
    MirrorTreatment mirrors = MirrorTreatment::images;
    bool reliability = false;
    Format format = Format::png;
    Layout layout = Layout::files;
    const Anaglyph* anaglyph = nullptr;  ///< for that layout
    cli::FrameRange frames{0, std::numeric_limits<std::int64_t>::max()};
    int repeat = 1;
    std::optional<double> refresh_hz;  ///< set: one picture per refresh of a display, of what has come by then
    std::string network;               ///< as given, for reports
    NetworkConditions conditions;      ///< what it says
    double extrapolation_limit_s =
        extrapolation_horizon_s;  ///< what moves is extrapolated so much beyond the clock at most; 0: held
    std::shared_ptr<const HdrDisplay> hdr_display;  ///< null: HdrDisplay's defaults, where the source is HDR
    bool json = false;
    cli::ProgressStyle progress = cli::ProgressStyle::automatic;
    std::filesystem::path out;
    bool out_is_video = false;  ///< `out` is one video of both eyes, rather than a folder
    bool overwrite = false;     ///< views of other settings in `out` make way

    /// Whether eyes are reprojected or judged by where mirrors are. Fill passes that look points up ask too.
    bool asks_for_mirrors() const { return mirrors != MirrorTreatment::surface || reliability; }
};

inline constexpr cli::Size default_size{1280, 720};
inline constexpr double default_fov_deg = 90;

}  // namespace equistream::play
