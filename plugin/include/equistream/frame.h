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

/// How both eyes lie in one picture. Values are part of the stream format; new ones are only appended.
enum class StereoPacking : std::uint8_t { none = 0, side_by_side = 1, top_bottom = 2 };

/// By StereoPacking: what programs call them.
inline constexpr const char* packing_names[] = {"none", "sbs", "top-bottom"};

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
    /// Above 0: colour is a mean over earlier frames too, at most so many where anything moved. Not in streams.
    std::uint32_t accumulated_frames = 0;
    /// Above 0: a window of a sphere of so many columns (window.h); `camera` says where it lies. Not in streams.
    int window_columns = 0;
    /// Of streams: both eyes lie in the picture, the left one first. `camera`, `camera_pose` and `eye` are the left
    /// one's alone; right_eye_of() says the right one's. Not written to EXR files.
    StereoPacking packing = StereoPacking::none;
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

/// Size of a frame's picture: the camera's, both eyes', or the atlas's.
inline int picture_width(const FrameInfo& info) {
    return info.patches ? info.patches->width()
                        : width_of(info.camera) * (info.packing == StereoPacking::side_by_side ? 2 : 1);
}
inline int picture_height(const FrameInfo& info) {
    return info.patches ? info.patches->height()
                        : height_of(info.camera) * (info.packing == StereoPacking::top_bottom ? 2 : 1);
}

/// Makes its sphere one of omnidirectional stereo for its eye. False: its eye is the centre, or its eyes are one.
[[nodiscard]] inline bool make_ods(FrameInfo& info) {
    const double side_m = ods_side_m(info.eye, info.ipd_m);
    std::get<EquirectCamera>(info.camera).ods_side_m = side_m;
    return side_m != 0;
}

/// Of a frame whose picture holds both eyes, or whose left eye is rendered: what a picture of the right one alone says.
inline FrameInfo right_eye_of(FrameInfo info) {
    info.packing = StereoPacking::none;
    info.eye = Eye::right;
    if (auto* sphere = std::get_if<EquirectCamera>(&info.camera); sphere != nullptr && sphere->ods_side_m != 0)
        sphere->ods_side_m = ods_side_m(Eye::right, info.ipd_m);
    info.camera_pose = camera_pose(info.camera, info.head, Eye::right, info.ipd_m, info.lock);
    return info;
}

/// Of a window.
inline WindowGrid window_grid_of(const FrameInfo& info) {
    return {info.window_columns, info.window_columns / 2, width_of(info.camera), height_of(info.camera)};
}

/// Whether a frame of the right eye is where right_eye_of() puts it beside the left one's.
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

/// Planes keyed by AovInfo::name. All planes have the picture's width and height; a Frame owns its planes.
struct Frame {
    FrameInfo info;
    std::map<std::string, FloatImage, std::less<>> planes;
    std::map<std::string, IdImage, std::less<>> ids;
};

}  // namespace equistream
