#pragma once
/// A frame: one camera pose plus planes. This is what travels from a host to files, streams and the client.
#include <equistream/camera.h>
#include <equistream/depth_code_info.h>
#include <equistream/image.h>
#include <equistream/object_motion.h>
#include <equistream/patches.h>
#include <equistream/visible_loss.h>
#include <equistream/window.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// Of the encoders' constant rate factor, which is an average quantiser (QP).
inline constexpr int worst_crf = 51;

/// The largest number of a frame; the least is 0.
inline constexpr std::int64_t max_frame_index = 999999999;
/// The largest absolute value of a frame's time. Seconds since 1970 lie well within it.
inline constexpr double max_time_s = 1e10;
/// The longest name of a scene, a host or a geometry. Sequences want UTF-8: a manifest could not hold other bytes.
inline constexpr std::size_t max_name_bytes = 255;

/// Everything a client must know to use a frame. Travels in EXR attributes and inside the coded picture.
struct FrameInfo {
    std::int64_t index = 0;
    double time_s = 0;
    double frames_per_second = 30;
    Camera camera = EquirectCamera{};
    Pose camera_pose;  ///< world from camera, at this frame
    Pose head;         ///< the head this camera was placed for
    Eye eye = Eye::centre;
    double ipd_m = default_ipd_m;
    AxisLock lock = AxisLock::world;
    double head_radius_m = 0;  ///< the head box: a ball of this radius around every path point
    double exposure = 1;       ///< factor on scene-referred radiance before the display transform
    std::uint64_t seed = 0;
    std::uint32_t samples_per_pixel = 0;
    std::string scene;  ///< the scene's name; at most max_name_bytes
    std::string host;   ///< renderer name and version; at most max_name_bytes
    /// Names the geometry that was rendered (load_scene's, where the host has it); empty: not said.
    std::string geometry_fingerprint;
    /// Library, version and quality that took the noise out of colour; empty: as rendered. At most max_name_bytes.
    std::string denoiser;
    /// Above 0: colour is a mean over earlier frames too, at most so many where anything moved.
    std::uint32_t accumulated_frames = 0;
    /// Above 0: the picture is a window of a sphere of so many columns (window.h); `camera` says where it is.
    int window_columns = 0;
    /// Set: the picture is an atlas of patches around the sphere that `camera` and `camera_pose` are of.
    std::optional<PatchAtlas> patches;
    /// Of a depth track's picture only. Not written to EXR files.
    std::optional<DepthCodeInfo> depth_code;
    /// Quality that the picture's track was coded at, 0 (best) to worst_crf; nothing: not coded, without loss, or not
    /// said. Not written to EXR files.
    std::optional<float> crf;
    /// How visibly off the track's colours are, where the encoder measured it. Not written to EXR files.
    std::optional<VisibleLoss> visible_loss;
    /// What of a main picture moves by itself, where somebody found out (`encode --motion`); empty: nothing, or not
    /// said. Not written to EXR files.
    std::vector<MovingRegion> moving;
};

/// As measured, else as usual at its CRF; nothing where that is not said.
inline std::optional<VisibleLoss> visible_loss_of(const FrameInfo& info) {
    if (!info.visible_loss && info.crf)
        return usual_coding_loss(double(*info.crf));
    return info.visible_loss;
}

/// Size of a frame's picture: the camera's, or the atlas's.
inline int picture_width(const FrameInfo& info) {
    return info.patches ? info.patches->width() : width_of(info.camera);
}
inline int picture_height(const FrameInfo& info) {
    return info.patches ? info.patches->height() : height_of(info.camera);
}

/// Of a window.
inline WindowGrid window_grid_of(const FrameInfo& info) {
    return {info.window_columns, info.window_columns / 2, width_of(info.camera), height_of(info.camera)};
}

/// Planes keyed by AovInfo::name. All planes have the picture's width and height; a Frame owns its planes.
struct Frame {
    FrameInfo info;
    std::map<std::string, FloatImage, std::less<>> planes;
    std::map<std::string, IdImage, std::less<>> ids;
};

}  // namespace equistream
