#pragma once
/// What a viewer sends its server: docs/stream-format.md, "From the viewer". One object, one thread.
#include <equistream/camera.h>
#include <equistream/window.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace equistream {

struct ViewerPose {
    double time_s = 0;                 ///< of the picture on show
    Pose head;                         ///< in the scene's world
    std::optional<ViewExtent> view{};  ///< what the viewer shows; nothing: it does not say
    bool steers = true;                ///< false: the head has only turned; the pose says where it looks
};

std::vector<std::uint8_t> encode_viewer_pose(const ViewerPose& pose);

/// Finds messages in whatever comes. What is none is passed over, and so are messages of other versions and kinds;
/// memory is bounded.
class ViewerMessageReader {
public:
    /// The next bytes, in pieces of any size. The last pose that has been completed by them and is one: finite numbers,
    /// a unit quaternion.
    std::optional<ViewerPose> take(std::span<const std::uint8_t> bytes);

private:
    bool at_message();

    std::vector<std::uint8_t> read_;  ///< of messages that are not whole yet
};

}  // namespace equistream
