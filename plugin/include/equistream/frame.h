#pragma once
/// A frame: one camera pose and its planes. Hosts, files, streams and the client exchange frames.
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

/// Largest (worst) constant rate factor of x264 and x265, which is an average quantiser (QP); the best is 0.
inline constexpr int worst_crf = 51;

/// Largest index of a frame; the smallest is 0.
inline constexpr std::int64_t max_frame_index = 999999999;
/// Largest absolute value of a frame's time, in seconds. Seconds since 1970 lie well within it.
inline constexpr double max_time_s = 1e10;
/// Longest name of a scene, a host or a geometry. A sequence's names are UTF-8, because its manifest is JSON.
inline constexpr std::size_t max_name_bytes = 255;

/// Arrangement of both eyes in one picture; none: one view alone. Values are part of the stream format; new ones are
/// only appended.
enum class StereoPacking : std::uint8_t { none = 0, side_by_side = 1, top_bottom = 2 };

/// Names in options, indexed by StereoPacking.
inline constexpr const char* packing_names[] = {"none", "sbs", "top-bottom"};

/// Everything that a client needs to know of a frame. Stored in EXR attributes, and in a coded picture's frame data.
struct FrameInfo {
    std::int64_t index = 0;  ///< 0 to max_frame_index
    double time_s = 0;       ///< -max_time_s to max_time_s
    double frames_per_second = 30;
    Camera camera = EquirectCamera{};
    Pose camera_pose;  ///< world from camera, at this frame
    Pose head;         ///< world from head, for which the camera was placed
    Eye eye = Eye::centre;
    double ipd_m = default_ipd_m;
    AxisLock lock = AxisLock::world;
    double head_radius_m = 0;  ///< head box: radius of a ball around each point of the path, for the head's centre
    double exposure = 1;       ///< factor on scene-referred radiance before the display transform
    std::uint64_t seed = 0;    ///< of the random numbers that it was rendered with
    std::uint32_t samples_per_pixel = 0;
    std::string scene;  ///< the scene's name; at most max_name_bytes
    std::string host;   ///< renderer name and version; at most max_name_bytes
    /// Fingerprint of the rendered geometry, at most max_name_bytes; empty: unknown. Clients refuse another scene.
    std::string geometry_fingerprint;
    /// Denoiser of colour: library, version and quality, at most max_name_bytes; empty: not denoised.
    std::string denoiser;
    /// Above 0: colour is a mean over this and earlier frames, at most so many where anything moved. Not in streams.
    std::uint32_t accumulated_frames = 0;
    /// Above 0: a window of a sphere with so many columns (window.h); `camera` is the window's. Not in streams.
    int window_columns = 0;
    /// Streams only: both eyes share the picture, the left one first. `camera`, `camera_pose` and `eye` are the left
    /// eye's; right_eye_of() gives the right eye's. Not written to EXR files.
    StereoPacking packing = StereoPacking::none;
    /// Set: the picture is an atlas of patches; `camera` and `camera_pose` are the main sphere's.
    std::optional<PatchAtlas> patches;
    /// Set for pictures of depth tracks only. Not written to EXR files.
    std::optional<DepthCodeInfo> depth_code;
    /// Constant rate factor of the picture's track, 0 (best) to worst_crf; nullopt: not coded, lossless, or unknown.
    /// Not written to EXR files.
    std::optional<float> crf;
    /// Visible errors of the track's colours, if the encoder measured them. Not written to EXR files.
    std::optional<VisibleLoss> visible_loss;
    /// Moving objects of a main picture (`encode --motion`); empty: none, or unknown. Not written to EXR files.
    std::vector<MovingRegion> moving;
};

/// The measured visible errors, else the usual ones at its CRF; nullopt if that is unknown too.
inline std::optional<VisibleLoss> visible_loss_of(const FrameInfo& info) {
    if (!info.visible_loss && info.crf)
        return usual_coding_loss(double(*info.crf));
    return info.visible_loss;
}

/// Size of a frame's picture in pixels: the camera's, that of both packed eyes, or the atlas's.
inline int picture_width(const FrameInfo& info) {
    return info.patches ? info.patches->width()
                        : width_of(info.camera) * (info.packing == StereoPacking::side_by_side ? 2 : 1);
}
inline int picture_height(const FrameInfo& info) {
    return info.patches ? info.patches->height()
                        : height_of(info.camera) * (info.packing == StereoPacking::top_bottom ? 2 : 1);
}

/// Turns its equirect camera into omnidirectional stereo for info.eye. False if that has no stereo: the eye is the
/// centre, or ipd_m is 0.
[[nodiscard]] inline bool make_ods(FrameInfo& info) {
    const double side_m = ods_side_m(info.eye, info.ipd_m);
    std::get<EquirectCamera>(info.camera).ods_side_m = side_m;
    return side_m != 0;
}

/// Frame data of the right eye alone, without packing. `info` is the left eye's, or belongs to a picture of both eyes.
inline FrameInfo right_eye_of(FrameInfo info) {
    info.packing = StereoPacking::none;
    info.eye = Eye::right;
    if (auto* sphere = std::get_if<EquirectCamera>(&info.camera); sphere != nullptr && sphere->ods_side_m != 0)
        sphere->ods_side_m = ods_side_m(Eye::right, info.ipd_m);
    info.camera_pose = camera_pose(info.camera, info.head, Eye::right, info.ipd_m, info.lock);
    return info;
}

/// The grid of a frame that is a window (window_columns above 0).
inline WindowGrid window_grid_of(const FrameInfo& info) {
    return {info.window_columns, info.window_columns / 2, width_of(info.camera), height_of(info.camera)};
}

/// Whether `right` is a right eye's frame with the camera and pose that right_eye_of(left) has, up to rounding (1e-9).
inline bool is_right_eye_of(const FrameInfo& left, const FrameInfo& right) {
    constexpr double rounding = 1e-9;
    const FrameInfo expected = right_eye_of(left);
    const auto *a = std::get_if<EquirectCamera>(&expected.camera), *b = std::get_if<EquirectCamera>(&right.camera);
    const Pose &p = expected.camera_pose, &q = right.camera_pose;
    return left.eye == Eye::left && right.eye == Eye::right && a != nullptr && b != nullptr && a->width == b->width &&
           a->height == b->height && a->range.longitude_min == b->range.longitude_min &&
           a->range.longitude_max == b->range.longitude_max && a->range.latitude_min == b->range.latitude_min &&
           a->range.latitude_max == b->range.latitude_max && a->ods_side_m == b->ods_side_m &&
           glm::distance(p.position_m, q.position_m) < rounding &&
           std::abs(glm::dot(p.orientation, q.orientation)) > 1 - rounding;
}

/// One frame in memory. It owns its planes, which are keyed by AovInfo::name and have the picture's width and height.
struct Frame {
    FrameInfo info;
    std::map<std::string, FloatImage, std::less<>> planes;  ///< all but SampleType::id
    std::map<std::string, IdImage, std::less<>> ids;        ///< SampleType::id
};

}  // namespace equistream
