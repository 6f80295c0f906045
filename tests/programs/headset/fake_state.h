#pragma once
/// What the runtime for tests remembers: where the session and the frame stand, what was made and not destroyed, and
/// what was submitted.
#include "fake_script.h"

#include <epoxy/gl.h>

#include <epoxy/glx.h>

#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_TIMESPEC
#include <openxr/openxr.h>

#include <ctime>
#include <openxr/openxr_platform.h>

#include <cstdint>
#include <cstring>
#include <deque>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace fake {

struct Swapchain {
    std::vector<std::uint32_t> images;  ///< names of textures
    std::uint32_t image = 0;            ///< acquired last
    int width = 0, height = 0;
    bool acquired = false, waited = false;
};

inline constexpr XrDuration period_ns = 11111111;

/// One of each at a time.
inline const auto instance_handle = reinterpret_cast<XrInstance>(std::uintptr_t{1});
inline const auto session_handle = reinterpret_cast<XrSession>(std::uintptr_t{2});

struct State {
    std::string folder;
    Script script;
    std::size_t frame = 0;

    bool has_instance = false, has_session = false, asked_requirements = false;
    bool ready = false, running = false, stopping = false, exits = false, lost = false;
    bool waited = false, begun = false;
    XrTime display_time = 1000000000;
    std::map<std::uintptr_t, XrPosef> spaces;
    std::map<std::uintptr_t, Swapchain> swapchains;
    int begun_sessions = 0, made_spaces = 0, made_swapchains = 0;
    std::deque<XrEventDataBuffer> events;
    std::string ready_until;  ///< a file that the session waits for before it is ready; empty: none
    std::ofstream log;
    long pictures_at_begin = 0;

    bool load();
    void close();
    const Frame& now() const { return script.frames[frame]; }
    bool is_there(const std::string& name) const;
    /// The frame was submitted: what the script has after it.
    void go_on();
    /// A call that OpenXR does not allow there: it is written down and refused.
    XrResult broken(const char* what, XrResult why = XR_ERROR_CALL_ORDER_INVALID);
    template <typename Event>
    void send(const Event& event) {
        static_assert(sizeof(Event) <= sizeof(XrEventDataBuffer));
        std::memcpy(&events.emplace_back(), &event, sizeof event);
    }
    void send(XrSessionState next);
    /// Of another value than any before it.
    std::uintptr_t new_handle() { return next_handle_++; }
    bool take(XrEventDataBuffer& event);
    /// Pictures that the viewer has written so far.
    long pictures() const;
    /// Reads back what is shown; false where it lies outside of its swapchain, or that is not there.
    bool record(const XrCompositionLayerProjection& layer);

private:
    void send_recentred(int frames_on);
    std::uintptr_t next_handle_ = 16;
};

extern State state;

std::string script_folder();

}  // namespace fake
