#include "xr_calls.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace equistream::xr {

void check(XrResult result, const char* call) {
    if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST || result == XR_SESSION_LOSS_PENDING)
        throw WorkError(lost);
    if (XR_FAILED(result))
        throw WorkError("the headset's runtime: " + std::string(call) + ": " + name_of(result));
}

Pose to_pose(const XrPosef& pose) {
    const auto& [q, p] = pose;
    return {{p.x, p.y, p.z}, glm::normalize(glm::dquat(q.w, q.x, q.y, q.z))};
}

XrPosef from_pose(const Pose& pose) {
    const glm::dquat& q = pose.orientation;
    const glm::dvec3& p = pose.position_m;
    return {{float(q.x), float(q.y), float(q.z), float(q.w)}, {float(p.x), float(p.y), float(p.z)}};
}

namespace {

/// Of 8 bits a channel; ours are sRGB. What a runtime has besides, it takes for linear.
constexpr std::int64_t picture_format = GL_SRGB8_ALPHA8;

bool has_extension(const char* name) {
    std::uint32_t count = 0;
    if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr)))
        return false;
    std::vector<XrExtensionProperties> known(count, made<XrExtensionProperties>(XR_TYPE_EXTENSION_PROPERTIES));
    return XR_SUCCEEDED(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, known.data())) &&
           std::ranges::any_of(
               known, [name](const XrExtensionProperties& one) { return std::strcmp(one.extensionName, name) == 0; });
}

template <typename Function>
Function function_of(XrInstance instance, const char* name) {
    PFN_xrVoidFunction function = nullptr;
    check(xrGetInstanceProcAddr(instance, name, &function), name);
    return reinterpret_cast<Function>(function);
}

/// What the current context was made with.
GLXFBConfig config_of(Display* display, GLXContext context) {
    int id = 0, screen = 0, count = 0;
    glXQueryContext(display, context, GLX_FBCONFIG_ID, &id);
    glXQueryContext(display, context, GLX_SCREEN, &screen);
    const std::array wanted = {GLX_FBCONFIG_ID, id, int(None)};
    GLXFBConfig* found = glXChooseFBConfig(display, screen, wanted.data(), &count);
    if (found == nullptr || count == 0)
        throw WorkError("the window's context cannot be found by its GLX configuration");
    const GLXFBConfig config = found[0];
    XFree(found);
    return config;
}

}  // namespace

XrInstance create_instance() {
    std::vector<const char*> extensions = {XR_KHR_OPENGL_ENABLE_EXTENSION_NAME};
    if (has_extension(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME))
        extensions.push_back(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
    auto wanted = made<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    std::strncpy(wanted.applicationInfo.applicationName, "equistream", XR_MAX_APPLICATION_NAME_SIZE - 1);
    // No more than is used: older runtimes refuse newer versions, whatever headers this was compiled with.
    wanted.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    wanted.enabledExtensionCount = std::uint32_t(extensions.size());
    wanted.enabledExtensionNames = extensions.data();
    XrInstance instance = XR_NULL_HANDLE;
    const XrResult result = xrCreateInstance(&wanted, &instance);
    if (result == XR_ERROR_EXTENSION_NOT_PRESENT)
        throw InputError(expected_found("--headset", "an OpenXR runtime that OpenGL can draw for", "one without"));
    if (XR_FAILED(result))
        throw InputError(expected_found("--headset", "an OpenXR runtime (the system's active one, or XR_RUNTIME_JSON)",
                                        name_of(result)));
    return instance;
}

XrSession create_session(XrInstance instance, XrSystemId system) {
    auto required = made<XrGraphicsRequirementsOpenGLKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
    check(function_of<PFN_xrGetOpenGLGraphicsRequirementsKHR>(instance, "xrGetOpenGLGraphicsRequirementsKHR")(
              instance, system, &required),
          "xrGetOpenGLGraphicsRequirementsKHR");
    GLint major = 0, minor = 0;
    glGetIntegerv(GL_MAJOR_VERSION, &major);
    glGetIntegerv(GL_MINOR_VERSION, &minor);
    const XrVersion have = XR_MAKE_VERSION(std::uint64_t(major), std::uint64_t(minor), 0);
    if (have < required.minApiVersionSupported)
        throw InputError(expected_found("--headset",
                                        formatted("OpenGL %d.%d, which the runtime needs",
                                                  int(XR_VERSION_MAJOR(required.minApiVersionSupported)),
                                                  int(XR_VERSION_MINOR(required.minApiVersionSupported))),
                                        formatted("%d.%d", major, minor)));
    auto binding = made<XrGraphicsBindingOpenGLXlibKHR>(XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR);
    binding.xDisplay = glXGetCurrentDisplay();
    binding.glxContext = glXGetCurrentContext();
    binding.glxDrawable = glXGetCurrentDrawable();
    if (binding.xDisplay == nullptr || binding.glxContext == nullptr)
        throw InputError(expected_found("--headset", "a window on an X11 display with GLX", "another kind of window"));
    binding.glxFBConfig = config_of(binding.xDisplay, binding.glxContext);
    int visual = 0;
    glXGetFBConfigAttrib(binding.xDisplay, binding.glxFBConfig, GLX_VISUAL_ID, &visual);
    binding.visualid = std::uint32_t(visual);
    auto wanted = made<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
    wanted.next = &binding;
    wanted.systemId = system;
    XrSession session = XR_NULL_HANDLE;
    check(xrCreateSession(instance, &wanted, &session), "xrCreateSession");
    return session;
}

void require_our_format(XrSession session) {
    const auto formats = list<std::int64_t>({}, "xrEnumerateSwapchainFormats",
                                            [&](std::uint32_t capacity, std::uint32_t* count, std::int64_t* to) {
                                                return xrEnumerateSwapchainFormats(session, capacity, count, to);
                                            });
    if (std::ranges::find(formats, picture_format) == formats.end())
        throw InputError(
            expected_found("--headset", "a runtime with sRGB pictures of 8 bits a channel", "one without"));
}

XrSwapchain create_swapchain(XrSession session, gl::Size size) {
    auto wanted = made<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
    wanted.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT;
    wanted.format = picture_format;
    wanted.sampleCount = 1;
    wanted.width = std::uint32_t(size.width);
    wanted.height = std::uint32_t(size.height);
    wanted.faceCount = 1;
    wanted.arraySize = 1;
    wanted.mipCount = 1;
    XrSwapchain swapchain = XR_NULL_HANDLE;
    check(xrCreateSwapchain(session, &wanted, &swapchain), "xrCreateSwapchain");
    return swapchain;
}

RuntimeClock::RuntimeClock(XrInstance instance) : instance_(instance) {
    PFN_xrVoidFunction function = nullptr;
    if (XR_SUCCEEDED(xrGetInstanceProcAddr(instance, "xrConvertTimespecTimeToTimeKHR", &function)))
        convert_ = reinterpret_cast<PFN_xrConvertTimespecTimeToTimeKHR>(function);
}

std::optional<double> RuntimeClock::seconds_until(XrTime time) const {
    XrTime now = 0;
    timespec monotonic{};
    if (convert_ == nullptr || clock_gettime(CLOCK_MONOTONIC, &monotonic) != 0 ||
        XR_FAILED(convert_(instance_, &monotonic, &now)))
        return std::nullopt;
    return 1e-9 * double(time - now);
}

}  // namespace equistream::xr
