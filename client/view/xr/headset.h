#pragma once
/// A headset by the OpenXR loader: one session on the current GLX context, one frame after the other. In the thread
/// that the context is current in. Failures of the runtime throw WorkError in one line that names the call.
#include <client/pipeline/covering_view.h>

#include <client/gpu/objects.h>

#include <array>
#include <memory>
#include <optional>

namespace equistream {

/// Where a headset's eyes will be when a frame is seen: in the space it was centred in, axes as of a camera.
struct HeadsetView {
    Pose head;  ///< between the eyes
    std::array<Pose, 2> eyes;
    CoveringView view;
    double until_seen_s = 0;  ///< from when it was said
};

class Headset {
public:
    /// OpenXR's loader is to say nothing on standard error, where ours is one line. Changes the environment: before
    /// there are other threads.
    static void be_quiet();

    /// Throws InputError in one line where there is no runtime, no headset, or none that OpenGL can draw for.
    Headset();
    ~Headset();
    Headset(const Headset&) = delete;
    Headset& operator=(const Headset&) = delete;

    /// What the runtime has to say; sessions are begun and ended as it wants. Throws WorkError where it was lost.
    void poll();
    /// Frames are wanted: begin_frame and end_frame, in turns.
    bool is_running() const { return running_; }
    /// The runtime, or who wears it, wants no more.
    bool is_over() const { return over_; }

    /// Waits until the next frame is to be made. Nothing where nobody sees it; end_frame() all the same.
    std::optional<HeadsetView> begin_frame();
    /// Where it is drawn: a framebuffer of both views side by side, the left one first, the first row of pixels at its
    /// bottom as in OpenGL. Only of a frame that is seen.
    GLuint framebuffer();
    gl::Size size() const { return size_; }  ///< of that framebuffer
    void end_frame();

    /// Where the head is now is the middle of the space from the next frame on, ahead is where it looks along the
    /// floor. Where the runtime centres its own space, that is the middle from then on.
    void recentre();

private:
    struct Handles;

    void find_system();
    void create_swapchain(const CoveringView& view);
    void create_space();
    void centre_with_runtime();
    void begin_session();
    std::optional<HeadsetView> locate();
    void acquire();

    std::unique_ptr<Handles> handles_;
    bool running_ = false, over_ = false;
    std::optional<HeadsetView> seen_;  ///< of the frame that was begun
    Pose centre_;                      ///< of our space in the runtime's
    std::optional<Pose> head_;         ///< seen last
    gl::Size most_;                    ///< that a view may have
    int columns_ = 0;                  ///< that the runtime recommends
    gl::Size size_;
    int acquired_ = -1;
};

}  // namespace equistream
