#pragma once
/// Messages from a viewer to its server (docs/stream-format.md, "From the viewer"). One object, one thread.
#include <equistream/camera.h>
#include <equistream/window.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace equistream {

struct ViewerPose {
    double time_s = 0;                 ///< time of the picture shown
    Pose head;                         ///< world from head
    std::optional<ViewExtent> view{};  ///< the viewer's field of view; nullopt: unknown
    bool steers = true;  ///< true: a live server may render from here; false: the pose only gives the view
};

/// The message's bytes, header included.
std::vector<std::uint8_t> encode_viewer_pose(const ViewerPose& pose);

/// Finds messages in untrusted bytes. Skips bytes that form no message, and messages of other versions and kinds. Its
/// memory is bounded.
class ViewerMessageReader {
public:
    /// Takes the next bytes, in pieces of any size. Returns the last valid pose that they complete, if any: finite
    /// numbers, a position within 1e9 m less max_ipd_m, a unit quaternion within 1e-6.
    std::optional<ViewerPose> take(std::span<const std::uint8_t> bytes);

private:
    bool at_message();

    std::vector<std::uint8_t> read_;  ///< of messages that are not whole yet
};

}  // namespace equistream
