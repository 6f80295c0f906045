#pragma once
/// Tells a server where the head is, over the connection on which its stream comes (docs/stream-format.md, "From the
/// viewer"). Any thread may send.
#include <equistream/frame.h>
#include <equistream/viewer_message.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>

namespace equistream {

class PoseSender {
public:
    /// Takes what it can of the bytes without waiting; false: they are lost.
    using Connection = std::function<bool(std::span<const std::uint8_t>)>;

    /// At most 30 times a second, and no head twice that shows the same. Whether it was sent.
    bool send(const ViewerPose& pose);
    /// What the viewer shows, which goes with its poses from now on.
    void look_through(const PerspectiveCamera& view);

    /// What is sent goes there from now on; null: nowhere.
    void use(Connection connection);

private:
    std::mutex mutex_;
    Connection connection_;
    std::optional<ViewExtent> view_, last_view_;
    std::optional<Pose> last_;
    bool last_steers_ = true;
    std::chrono::steady_clock::time_point last_at_;
};

}  // namespace equistream
