/// An OpenXR runtime for tests, found by the loader through XR_RUNTIME_JSON: no device, a head path out of a file, and
/// everything that is submitted written to a folder. It refuses calls that come in another order than OpenXR allows,
/// and handles that were not made or are destroyed.
///
/// EQUISTREAM_FAKE_XR   a folder with `script.txt`. A frame is "x y z qw qx qy qz" of the head (in LOCAL), "idle"
///                      (nobody sees it) or "untracked" (nobody knows where the head is). After one may stand
///                      "until NAME": it is asked for again and again until a file of that name lies in the folder;
///                      "recentre N": so many frames later LOCAL begins anew, in which heads are given from there on;
///                      "stop [NAME]": the session stops, and is ready again once that file is there;
///                      and ends, "exit", "loss" (of the session), "instance-loss" or "lost-call" (said by a call).
///                      Of the frames after it: "fov OUT IN UP DOWN" in sixteenths of tangents, "ipd M", "cant DEGREES"
///                      (eyes turned outwards). Of all: "lead-ms MS" (frames are seen so long after any time that
///                      is asked for), "no headset", "no opengl", "no srgb".
/// It writes there      frame.NNNN.EYE.ppm, and `log.jsonl`: a line a frame and one at the end.
#include "fake_objects.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

namespace fake {

namespace {

XrFovf fov_of(const Tangents& tangents, int eye) {
    const float out = std::atan(tangents.out / 16), in = std::atan(tangents.in / 16);
    return {eye == 0 ? -out : -in, eye == 0 ? in : out, std::atan(tangents.up / 16), -std::atan(tangents.down / 16)};
}

XrVector3f turned(const XrQuaternionf& q, XrVector3f v) {
    const auto cross = [](XrVector3f a, XrVector3f b) {
        return XrVector3f{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    };
    const XrVector3f u{q.x, q.y, q.z}, t = cross(u, v), s = cross(u, {2 * t.x, 2 * t.y, 2 * t.z});
    return {v.x + 2 * q.w * t.x + s.x, v.y + 2 * q.w * t.y + s.y, v.z + 2 * q.w * t.z + s.z};
}

XrQuaternionf product(const XrQuaternionf& a, const XrQuaternionf& b) {
    return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

/// A pose of LOCAL's in a space that was made at `space` in LOCAL.
XrPosef seen_from(const XrPosef& space, const XrPosef& pose) {
    const XrQuaternionf back{-space.orientation.x, -space.orientation.y, -space.orientation.z, space.orientation.w};
    const XrVector3f &p = pose.position, &o = space.position;
    return {product(back, pose.orientation), turned(back, {p.x - o.x, p.y - o.y, p.z - o.z})};
}

XrResult XRAPI_CALL locate_views(XrSession session, const XrViewLocateInfo* where, XrViewState* known,
                                 std::uint32_t capacity, std::uint32_t* count, XrView* views) {
    const auto space = state.spaces.find(reinterpret_cast<std::uintptr_t>(where->space));
    if (is_gone(session) || space == state.spaces.end())
        return gone("xrLocateViews");
    *count = 2;
    if (capacity < 2)
        return XR_SUCCESS;
    if (!state.begun || where->displayTime != state.display_time)
        return state.broken("xrLocateViews for another time than xrWaitFrame's");
    const Frame& frame = state.now();
    known->viewStateFlags = 0;
    if (frame.seen != Seen::untracked)
        known->viewStateFlags = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
    const XrPosef head = seen_from(space->second, frame.head);
    for (int eye = 0; eye < 2; ++eye) {
        const float outwards = eye == 0 ? -1.0f : 1.0f, half_rad = -0.5f * outwards * frame.cant_rad;
        const XrVector3f side = turned(head.orientation, {outwards * frame.ipd_m / 2, 0, 0});
        views[eye].pose = {product(head.orientation, {0, std::sin(half_rad), 0, std::cos(half_rad)}),
                           {head.position.x + side.x, head.position.y + side.y, head.position.z + side.z}};
        views[eye].fov = fov_of(frame.fov, eye);
    }
    return XR_SUCCESS;
}

XrResult XRAPI_CALL wait_frame(XrSession session, const XrFrameWaitInfo*, XrFrameState* frame) {
    if (is_gone(session))
        return gone("xrWaitFrame");
    if (state.lost)
        return XR_ERROR_SESSION_LOST;
    if (!state.running || state.waited)
        return state.broken("xrWaitFrame out of turn");
    state.waited = true;
    state.display_time += period_ns;
    frame->predictedDisplayTime = state.display_time;
    frame->predictedDisplayPeriod = period_ns;
    frame->shouldRender = state.now().seen == Seen::by_nobody ? XR_FALSE : XR_TRUE;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL begin_frame(XrSession session, const XrFrameBeginInfo*) {
    if (is_gone(session))
        return gone("xrBeginFrame");
    if (!state.waited || state.begun)
        return state.broken("xrBeginFrame out of turn");
    state.begun = true;
    state.pictures_at_begin = state.pictures();
    return XR_SUCCESS;
}

XrResult XRAPI_CALL end_frame(XrSession session, const XrFrameEndInfo* end) {
    if (is_gone(session))
        return gone("xrEndFrame");
    if (!state.begun || is_any_acquired())
        return state.broken("xrEndFrame out of turn");
    if (end->displayTime != state.display_time || end->environmentBlendMode != XR_ENVIRONMENT_BLEND_MODE_OPAQUE)
        return state.broken("xrEndFrame with another time or blend mode");
    if (end->layerCount != (state.now().seen == Seen::by_somebody ? 1u : 0u))
        return state.broken("xrEndFrame with another number of layers");
    if (end->layerCount == 1) {
        const auto& layer = *reinterpret_cast<const XrCompositionLayerProjection*>(end->layers[0]);
        if (layer.type != XR_TYPE_COMPOSITION_LAYER_PROJECTION)
            return state.broken("a layer that is no projection");
        if (!state.spaces.contains(reinterpret_cast<std::uintptr_t>(layer.space)))
            return gone("xrEndFrame with a space");
        if (!state.record(layer))
            return state.broken("a view outside of its swapchain");
    }
    state.waited = state.begun = false;
    state.go_on();
    return XR_SUCCESS;
}

XrResult XRAPI_CALL begin_session(XrSession session, const XrSessionBeginInfo* begin) {
    if (is_gone(session))
        return gone("xrBeginSession");
    if (!state.ready || state.running ||
        begin->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
        return state.broken("xrBeginSession out of turn");
    state.ready = false;
    state.running = true;
    ++state.begun_sessions;
    for (const XrSessionState next :
         {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED})
        state.send(next);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL end_session(XrSession session) {
    if (is_gone(session))
        return gone("xrEndSession");
    if (!state.running || !state.stopping || state.waited)
        return state.broken("xrEndSession out of turn");
    state.running = state.stopping = false;
    state.send(XR_SESSION_STATE_IDLE);
    state.send(state.exits ? XR_SESSION_STATE_EXITING : XR_SESSION_STATE_READY);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL poll_event(XrInstance, XrEventDataBuffer* event) {
    return state.take(*event) ? XR_SUCCESS : XR_EVENT_UNAVAILABLE;
}

XrResult XRAPI_CALL create_session(XrInstance, const XrSessionCreateInfo* wanted, XrSession* session) {
    const auto* binding = static_cast<const XrGraphicsBindingOpenGLXlibKHR*>(wanted->next);
    if (state.has_session)
        return state.broken("xrCreateSession again", XR_ERROR_LIMIT_REACHED);
    if (!state.asked_requirements)
        return XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING;
    if (binding == nullptr || binding->type != XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR ||
        binding->xDisplay == nullptr || binding->glxContext == nullptr || binding->glxDrawable == 0 ||
        binding->glxFBConfig == nullptr || binding->visualid == 0)
        return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    *session = session_handle;
    state.has_session = true;
    state.send(XR_SESSION_STATE_IDLE);
    state.send(XR_SESSION_STATE_READY);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL view_sizes(XrInstance, XrSystemId, XrViewConfigurationType, std::uint32_t capacity,
                               std::uint32_t* count, XrViewConfigurationView* to) {
    *count = 2;
    for (std::uint32_t i = 0; i < capacity && i < 2; ++i) {
        to[i].recommendedImageRectWidth = 300;  // ten pixels for each sixteenth of its tangents
        to[i].recommendedImageRectHeight = 320;
        to[i].maxImageRectWidth = to[i].maxImageRectHeight = 2048;
        to[i].recommendedSwapchainSampleCount = to[i].maxSwapchainSampleCount = 1;
    }
    return XR_SUCCESS;
}

XrResult XRAPI_CALL blend_modes(XrInstance, XrSystemId, XrViewConfigurationType, std::uint32_t capacity,
                                std::uint32_t* count, XrEnvironmentBlendMode* to) {
    *count = 1;
    if (capacity > 0)
        to[0] = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL get_system(XrInstance, const XrSystemGetInfo*, XrSystemId* system) {
    *system = 1;
    return state.script.has_headset ? XR_SUCCESS : XR_ERROR_FORM_FACTOR_UNAVAILABLE;
}

XrResult XRAPI_CALL system_properties(XrInstance, XrSystemId, XrSystemProperties* properties) {
    properties->graphicsProperties = {2048, 4096, 16};
    return XR_SUCCESS;
}

XrResult XRAPI_CALL requirements(XrInstance, XrSystemId, XrGraphicsRequirementsOpenGLKHR* required) {
    required->minApiVersionSupported = XR_MAKE_VERSION(4, 3, 0);
    required->maxApiVersionSupported = XR_MAKE_VERSION(4, 6, 0);
    state.asked_requirements = true;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL extensions(const char*, std::uint32_t capacity, std::uint32_t* count, XrExtensionProperties* to) {
    // The loader asks before there is an instance.
    Script script;
    script.read(script_folder() + "/script.txt");
    std::vector<const char*> known;
    if (script.has_opengl)
        known.push_back(XR_KHR_OPENGL_ENABLE_EXTENSION_NAME);
    if (script.lead_ns > 0)
        known.push_back(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
    *count = std::uint32_t(known.size());
    for (std::uint32_t i = 0; i < capacity && i < *count; ++i)
        std::strcpy(to[i].extensionName, known[i]);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL create_instance(const XrInstanceCreateInfo* wanted, XrInstance* instance) {
    if (state.has_instance)
        return XR_ERROR_LIMIT_REACHED;
    if (!state.load())
        return XR_ERROR_RUNTIME_FAILURE;
    // The first runtimes have no more than that.
    if (wanted->applicationInfo.apiVersion != XR_MAKE_VERSION(1, 0, 0))
        return XR_ERROR_API_VERSION_UNSUPPORTED;
    state.has_instance = true;
    *instance = instance_handle;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL instance_properties(XrInstance, XrInstanceProperties* properties) {
    std::strcpy(properties->runtimeName, "fake");
    return XR_SUCCESS;
}

/// And what was made of it.
XrResult XRAPI_CALL destroy_session(XrSession session) {
    if (is_gone(session))
        return gone("xrDestroySession");
    if (is_any_acquired())
        return state.broken("xrDestroySession while an image is acquired");
    state.has_session = false;
    state.spaces.clear();
    state.swapchains.clear();
    return XR_SUCCESS;
}

XrResult XRAPI_CALL destroy_instance(XrInstance instance) {
    if (instance != instance_handle || !state.has_instance)
        return gone("xrDestroyInstance");
    if (state.has_session)
        state.broken("xrDestroyInstance before its session");
    state.has_instance = state.has_session = false;
    state.close();
    return XR_SUCCESS;
}

XrResult XRAPI_CALL time_of(XrInstance, const timespec*, XrTime* time) {
    *time = state.display_time - state.script.lead_ns;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL function_of(XrInstance, const char* name, PFN_xrVoidFunction* function) {
    struct Entry {
        const char* name;
        PFN_xrVoidFunction function;
    };
    const auto as = [](auto* f) { return reinterpret_cast<PFN_xrVoidFunction>(f); };
    static const Entry entries[] = {
        {"xrGetInstanceProcAddr", as(function_of)},
        {"xrEnumerateInstanceExtensionProperties", as(extensions)},
        {"xrCreateInstance", as(create_instance)},
        {"xrDestroyInstance", as(destroy_instance)},
        {"xrGetInstanceProperties", as(instance_properties)},
        {"xrGetSystem", as(get_system)},
        {"xrGetSystemProperties", as(system_properties)},
        {"xrEnumerateViewConfigurationViews", as(view_sizes)},
        {"xrEnumerateEnvironmentBlendModes", as(blend_modes)},
        {"xrGetOpenGLGraphicsRequirementsKHR", as(requirements)},
        {"xrCreateSession", as(create_session)},
        {"xrDestroySession", as(destroy_session)},
        {"xrBeginSession", as(begin_session)},
        {"xrEndSession", as(end_session)},
        {"xrPollEvent", as(poll_event)},
        {"xrCreateReferenceSpace", as(create_space)},
        {"xrDestroySpace", as(destroy_space)},
        {"xrEnumerateSwapchainFormats", as(formats)},
        {"xrCreateSwapchain", as(create_swapchain)},
        {"xrDestroySwapchain", as(destroy_swapchain)},
        {"xrEnumerateSwapchainImages", as(images)},
        {"xrAcquireSwapchainImage", as(acquire)},
        {"xrWaitSwapchainImage", as(wait_image)},
        {"xrReleaseSwapchainImage", as(release)},
        {"xrLocateViews", as(locate_views)},
        {"xrWaitFrame", as(wait_frame)},
        {"xrBeginFrame", as(begin_frame)},
        {"xrEndFrame", as(end_frame)},
        {"xrConvertTimespecTimeToTimeKHR", as(time_of)},
    };
    const bool tells_time = state.script.lead_ns > 0;
    for (const Entry& entry : entries)
        if (std::strcmp(entry.name, name) == 0 && (tells_time || entry.function != as(time_of))) {
            *function = entry.function;
            return XR_SUCCESS;
        }
    *function = nullptr;
    return XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace

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

XrResult negotiate(const LoaderInfo& loader, RuntimeRequest& runtime) {
    if (loader.min_interface > 1 || loader.max_interface < 1)
        return XR_ERROR_INITIALIZATION_FAILED;
    runtime.interface_version = 1;
    runtime.api_version = XR_MAKE_VERSION(1, 0, 0);
    runtime.function_of = function_of;
    return XR_SUCCESS;
}

}  // namespace fake

extern "C" __attribute__((visibility("default"))) XrResult XRAPI_CALL
xrNegotiateLoaderRuntimeInterface(const fake::LoaderInfo* loader, fake::RuntimeRequest* runtime) {
    return fake::negotiate(*loader, *runtime);
}
