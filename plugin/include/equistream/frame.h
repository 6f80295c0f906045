#pragma once
/// A frame: one camera pose plus planes. This is what travels from a host to files, streams and the client.
#include <equistream/camera.h>
#include <equistream/image.h>

#include <cstdint>
#include <map>
#include <string>

namespace equistream {

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
    double lean_m = 0;    ///< the head box: a ball of this radius around every path point
    double exposure = 1;  ///< factor on scene-referred radiance before the display transform
    std::uint64_t seed = 0;
    std::uint32_t samples_per_pixel = 0;
    std::string scene;  ///< the scene's name; at most 255 bytes
    std::string host;   ///< renderer name and version; at most 255 bytes
    /// Names the geometry that was rendered (load_scene's, where the host has it); empty: not said. At most 255 bytes.
    std::string geometry_fingerprint;
};

/// Planes keyed by AovInfo::name. All planes have the camera's width and height; a Frame owns its planes.
struct Frame {
    FrameInfo info;
    std::map<std::string, FloatImage, std::less<>> planes;
    std::map<std::string, IdImage, std::less<>> ids;
};

}  // namespace equistream
