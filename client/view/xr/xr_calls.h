#pragma once
/// OpenXR's C interface, as headset.cpp needs it.
#include <epoxy/gl.h>

#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_TIMESPEC
// Xlib and GLX come by way of epoxy's own header, before OpenXR's.
#include <ctime>
#include <epoxy/glx.h>
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "xr_names.h"

#include <client/gpu/objects.h>
#include <equistream/camera.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace equistream::xr {

inline constexpr XrViewConfigurationType stereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
inline constexpr const char* lost = "the headset was lost: its OpenXR runtime has ended the session";

/// All zero but for what it is.
template <typename Struct>
Struct made(XrStructureType type) {
    Struct blank{};
    blank.type = type;
    return blank;
}

/// Throws WorkError naming the call; of a session or a runtime that was lost it says that.
void check(XrResult result, const char* call);

/// What a function that gives lists gives; `blank` has what its elements are to be told.
template <typename Element, typename Call>
std::vector<Element> list(const Element& blank, const char* name, const Call& call) {
    std::uint32_t count = 0;
    check(call(0, &count, nullptr), name);
    std::vector<Element> elements(count, blank);
    if (count > 0)
        check(call(count, &count, elements.data()), name);
    elements.resize(count);
    return elements;
}

Pose to_pose(const XrPosef& pose);
XrPosef from_pose(const Pose& pose);

/// With OpenGL. Throws InputError where there is no runtime, or none with it.
XrInstance create_instance();
/// Bound to the GLX context that is current. Throws InputError where there is none.
XrSession create_session(XrInstance instance, XrSystemId system);
/// Throws InputError where the runtime takes no pictures as create_swapchain() makes them.
void require_our_format(XrSession session);
/// Of 8 bits a channel, whose values are taken for sRGB; to be drawn to and copied from.
XrSwapchain create_swapchain(XrSession session, gl::Size size);

/// The runtime's time and ours.
class RuntimeClock {
public:
    explicit RuntimeClock(XrInstance instance);
    /// Nothing where the runtime does not say what its time is by now.
    std::optional<double> seconds_until(XrTime time) const;

private:
    XrInstance instance_;
    PFN_xrConvertTimespecTimeToTimeKHR convert_ = nullptr;
};

}  // namespace equistream::xr
