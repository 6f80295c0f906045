#include "probes.h"

#include <client/gpu/context.h>
#include <client/view/xr/xr_names.h>

#include <equistream/error.h>
#include <equistream/text.h>

#include <X11/Xlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace equistream::doctor {

namespace {

constexpr const char* opengl_extension = "XR_KHR_opengl_enable";

struct Instance {
    XrInstance handle = XR_NULL_HANDLE;
    ~Instance() {
        if (handle != XR_NULL_HANDLE)
            xrDestroyInstance(handle);
    }
};

}  // namespace

Finding probe_opengl() {
    const std::unique_ptr<gl::Context> context = gl::make_offscreen_context();
    const gl::Driver driver = gl::Context::driver();
    return Finding::ok("OpenGL " + driver.version + " without a window, on " + driver.renderer +
                           (driver.is_software() ? ": in software, slow" : ""),
                       {{"vendor", driver.vendor},
                        {"renderer", driver.renderer},
                        {"version", driver.version},
                        {"is_software", driver.is_software()}});
}

Finding probe_display() {
    const char* name = std::getenv("DISPLAY");
    if (name == nullptr || *name == '\0')
        return {State::missing, "DISPLAY is not set", "", {}};
    Display* display = XOpenDisplay(nullptr);
    if (display == nullptr)
        return {State::missing, "DISPLAY is " + quotable(name, 100) + ", which cannot be opened", "", {}};
    const int screen = DefaultScreen(display);
    const int width = DisplayWidth(display, screen), height = DisplayHeight(display, screen);
    XCloseDisplay(display);
    return Finding::ok("display " + quotable(name, 100) + ", " + size_text(width, height),
                       {{"name", name}, {"width", width}, {"height", height}});
}

Finding probe_headset() {
    setenv("XR_LOADER_DEBUG", "none", 0);
    XrInstanceCreateInfo wanted{};
    wanted.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::strncpy(wanted.applicationInfo.applicationName, "equistream", XR_MAX_APPLICATION_NAME_SIZE - 1);
    wanted.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    wanted.enabledExtensionCount = 1;
    wanted.enabledExtensionNames = &opengl_extension;
    Instance instance;
    const XrResult result = xrCreateInstance(&wanted, &instance.handle);
    if (result == XR_ERROR_EXTENSION_NOT_PRESENT)
        return {State::missing, "the OpenXR runtime does not support OpenGL", "", {}};
    if (XR_FAILED(result))
        return {State::missing, "no OpenXR runtime answers: " + xr::name_of(result), "", {}};
    XrInstanceProperties runtime{};
    runtime.type = XR_TYPE_INSTANCE_PROPERTIES;
    xrGetInstanceProperties(instance.handle, &runtime);
    const std::string name = quotable(runtime.runtimeName, XR_MAX_RUNTIME_NAME_SIZE);
    XrSystemGetInfo system{};
    system.type = XR_TYPE_SYSTEM_GET_INFO;
    system.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    XrSystemId id = XR_NULL_SYSTEM_ID;
    const XrResult found = xrGetSystem(instance.handle, &system, &id);
    if (XR_FAILED(found))
        return {State::missing,
                "the OpenXR runtime " + name + ", but no headset: " + xr::name_of(found),
                "connect the headset, and start its runtime",
                {{"runtime", name}}};
    return Finding::ok("a headset, OpenXR runtime " + name, {{"runtime", name}});
}

}  // namespace equistream::doctor
