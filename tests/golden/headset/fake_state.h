#pragma once
/// What the runtime for tests remembers: its script, where the session and the frame stand, and what was submitted.
#include <epoxy/gl.h>

#include <epoxy/glx.h>

#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <cstdint>
#include <deque>
#include <fstream>
#include <string>
#include <vector>

namespace fake {

/// As the loader's documentation has them (its header is not installed).
struct LoaderInfo {
    std::uint32_t struct_type, struct_version;
    std::size_t struct_size;
    std::uint32_t min_interface, max_interface;
    XrVersion min_api, max_api;
};
struct RuntimeRequest {
    std::uint32_t struct_type, struct_version;
    std::size_t struct_size;
    std::uint32_t interface_version;
    XrVersion api_version;
    PFN_xrGetInstanceProcAddr function_of;
};

struct Frame {
    bool idle = false;
    XrPosef head{{0, 0, 0, 1}, {0, 0, 0}};
    std::string until;  ///< it is asked for again until a file of that name is there; empty: once
};

struct State {
    std::string folder;
    std::vector<Frame> frames;
    std::size_t frame = 0;
    bool ends_by_loss = false, has_headset = true;

    bool asked_requirements = false, ready = false, running = false, stopping = false;
    bool waited = false, begun = false, acquired = false, image_waited = false;
    XrTime display_time = 1000000000;
    std::vector<XrPosef> spaces;
    std::vector<std::uint32_t> images;
    std::uint32_t image = 0;
    int width = 0, height = 0;
    std::deque<XrSessionState> events;
    std::ofstream log;

    bool load();
    void close();
    /// To the frame after this one; false: there is none.
    bool go_on();
    /// A call that OpenXR does not allow there: it is written down and refused.
    XrResult broken(const char* what);
    void send(XrSessionState next) { events.push_back(next); }
    bool take(XrEventDataBuffer& event);
    void make_images(int columns, int rows);
    /// Reads back what is shown; false where it lies outside of the swapchain.
    bool record(const XrCompositionLayerProjection& layer);
};

}  // namespace fake
