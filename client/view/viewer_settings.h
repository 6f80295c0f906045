#pragma once
/// What a viewer is asked for, and what it says of itself in the end.
#include "face/content.h"
#include "kept_settings.h"
#include "shown_settings.h"

#include <client/playback/playback.h>
#include <client/view/gl/eye_renderer.h>
#include <equistream/colour.h>
#include <equistream/object_motion.h>
#include <scenes/library/scene.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

inline constexpr gl::Size default_window_size{1280, 720};
inline constexpr double default_view_fov_deg = 90;

/// How a decoder's pictures come to the GPU. mapped: it reads them where the decoder wrote them, in its driver's own
/// buffers, where the driver has such; copied: they are copied. by_driver: mapped, unless the driver draws on the CPU.
enum class PictureUpload { by_driver, mapped, copied };

struct ViewerSettings {
    std::string source;                     ///< file, URL or folder
    std::optional<SceneDescription> scene;  ///< whose geometry gives depth
    /// Nothing: the truth's, else as the defaults are.
    std::optional<gl::Size> size;
    std::optional<double> fov_deg;
    std::optional<double> ipd_m;  ///< nothing: what the frames are tagged with
    ShownSettings shown;          ///< in the beginning
    bool paused = false;
    std::shared_ptr<const HdrDisplay> hdr_display;  ///< how HDR comes to the display; null: HdrDisplay's defaults
    bool requires_hdr = true;                       ///< where `hdr_display` is given, the source must be HDR
    bool headset = false;                           ///< shown in one by OpenXR, the window beside it
    bool hardware = true;                           ///< decode by it where there is some
    PictureUpload upload = PictureUpload::by_driver;
    std::optional<double> predict_s;  ///< how far ahead the head is foretold; nothing: as far as is measured
    double extrapolation_limit_s =
        extrapolation_horizon_s;      ///< see Playback::extrapolation_s; 0: what moves stays where frames show it
    std::filesystem::path truth;      ///< folder of path-traced eyes of the same path; empty: there is none
    std::filesystem::path out = ".";  ///< of pictures and recordings
    double seconds = 0;               ///< after which it ends by itself; 0: when it is told to
    std::filesystem::path kept_in;    ///< file of kept settings; empty: nothing is kept
    KeptSettings kept;                ///< what was in it
};

struct ViewerReport {
    double seconds = 0;
    std::int64_t refreshes = 0;  ///< that were drawn: a still picture is drawn once
    std::int64_t frames = 0;     ///< that were shown
    double extrapolation_s = 0;  ///< by which what moves was shown later than in its frame, on average over refreshes
    std::optional<double> truth_db;  ///< PSNR of what was seen beside the truth, on average over refreshes
    double latency_s = 0;            ///< from the last look at what steers until the buffers were swapped, on average
    std::optional<double> playout_delay_s;  ///< of a live source, in the end
    std::string decoder;                    ///< of the last frame; empty: it was not coded
    double decode_ms = 0;                   ///< ReceivedPicture's, on average over frames
    std::size_t mapped_bytes = 0;           ///< of buffers that decoders wrote into, in the end
    /// Of all refreshes, in milliseconds; nothing unless stages were told apart.
    std::optional<gl::StageTimes::Row> stages_ms;
    std::vector<Fact> facts;  ///< what the panel says, in the end
};

}  // namespace equistream
