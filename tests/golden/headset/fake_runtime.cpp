/// An OpenXR runtime for tests, found by the loader through XR_RUNTIME_JSON: no device, a head path out of a file, and
/// everything that is submitted written to a folder. It refuses calls that come in another order than OpenXR allows.
///
/// EQUISTREAM_FAKE_XR   a folder with `script.txt`: one line a frame, "x y z qw qx qy qz" of the head (in LOCAL), or
///                      "idle" (nobody sees it); "until NAME" has the one before it again and again until a file of
///                      that name lies in the folder; at the end "exit" or "loss".
/// It writes there      frame.NNNN.EYE.pgm.. as PPM, and `log.jsonl`: a line a frame and one at the end.
#include "fake_state.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

namespace fake {

State state;

namespace {

/// Wider outwards and downwards, as headsets are; tangents in sixteenths.
XrFovf fov_of(int eye) {
    const float out = std::atan(17.0f / 16), in = std::atan(13.0f / 16);
    return {eye == 0 ? -out : -in, eye == 0 ? in : out, std::atan(14.0f / 16), -std::atan(18.0f / 16)};
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

XrResult XRAPI_CALL locate_views(XrSession, const XrViewLocateInfo* where, XrViewState* known, std::uint32_t capacity,
                                 std::uint32_t* count, XrView* views) {
    *count = 2;
    if (capacity < 2)
        return XR_SUCCESS;
    if (where->displayTime != state.display_time)
        return state.broken("xrLocateViews for another time than xrWaitFrame's");
    known->viewStateFlags = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
    const XrPosef head =
        seen_from(state.spaces.at(reinterpret_cast<std::uintptr_t>(where->space) - 1), state.frames[state.frame].head);
    for (int eye = 0; eye < 2; ++eye) {
        const XrVector3f side = turned(head.orientation, {eye == 0 ? -0.032f : 0.032f, 0, 0});
        views[eye].pose = {head.orientation,
                           {head.position.x + side.x, head.position.y + side.y, head.position.z + side.z}};
        views[eye].fov = fov_of(eye);
    }
    return XR_SUCCESS;
}

XrResult XRAPI_CALL wait_frame(XrSession, const XrFrameWaitInfo*, XrFrameState* frame) {
    if (!state.running || state.waited)
        return state.broken("xrWaitFrame out of turn");
    state.waited = true;
    state.display_time += 11111111;
    frame->predictedDisplayTime = state.display_time;
    frame->predictedDisplayPeriod = 11111111;
    frame->shouldRender = state.frames[state.frame].idle ? XR_FALSE : XR_TRUE;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL begin_frame(XrSession, const XrFrameBeginInfo*) {
    if (!state.waited || state.begun)
        return state.broken("xrBeginFrame out of turn");
    state.begun = true;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL acquire(XrSwapchain, const XrSwapchainImageAcquireInfo*, std::uint32_t* index) {
    if (!state.begun || state.acquired)
        return state.broken("xrAcquireSwapchainImage out of turn");
    state.acquired = true;
    *index = state.image = (state.image + 1) % std::uint32_t(state.images.size());
    return XR_SUCCESS;
}

XrResult XRAPI_CALL wait_image(XrSwapchain, const XrSwapchainImageWaitInfo*) {
    if (!state.acquired || state.image_waited)
        return state.broken("xrWaitSwapchainImage out of turn");
    state.image_waited = true;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL release(XrSwapchain, const XrSwapchainImageReleaseInfo*) {
    if (!state.image_waited)
        return state.broken("xrReleaseSwapchainImage out of turn");
    state.acquired = state.image_waited = false;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL end_frame(XrSession, const XrFrameEndInfo* end) {
    if (!state.begun || state.acquired)
        return state.broken("xrEndFrame out of turn");
    if (end->displayTime != state.display_time || end->environmentBlendMode != XR_ENVIRONMENT_BLEND_MODE_OPAQUE)
        return state.broken("xrEndFrame with another time or blend mode");
    const Frame& frame = state.frames[state.frame];
    if (end->layerCount != (frame.idle ? 0u : 1u))
        return state.broken("xrEndFrame with another number of layers");
    for (std::uint32_t i = 0; i < end->layerCount; ++i)
        if (end->layers[i]->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION)
            return state.broken("a layer that is no projection");
    if (end->layerCount == 1)
        if (!state.record(*reinterpret_cast<const XrCompositionLayerProjection*>(end->layers[0])))
            return state.broken("a view outside of its swapchain");
    state.waited = state.begun = false;
    if (!state.go_on())
        state.send(state.ends_by_loss ? XR_SESSION_STATE_LOSS_PENDING : XR_SESSION_STATE_STOPPING);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL begin_session(XrSession, const XrSessionBeginInfo* begin) {
    if (!state.ready || state.running ||
        begin->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
        return state.broken("xrBeginSession out of turn");
    state.running = true;
    for (const XrSessionState next :
         {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED})
        state.send(next);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL end_session(XrSession) {
    if (!state.running || !state.stopping)
        return state.broken("xrEndSession out of turn");
    state.running = false;
    state.send(XR_SESSION_STATE_IDLE);
    state.send(XR_SESSION_STATE_EXITING);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL poll_event(XrInstance, XrEventDataBuffer* event) {
    return state.take(*event) ? XR_SUCCESS : XR_EVENT_UNAVAILABLE;
}

XrResult XRAPI_CALL create_session(XrInstance, const XrSessionCreateInfo* wanted, XrSession* session) {
    const auto* binding = static_cast<const XrGraphicsBindingOpenGLXlibKHR*>(wanted->next);
    if (!state.asked_requirements)
        return XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING;
    if (binding == nullptr || binding->type != XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR ||
        binding->xDisplay == nullptr || binding->glxContext == nullptr || binding->glxDrawable == 0 ||
        binding->glxFBConfig == nullptr || binding->visualid == 0)
        return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    *session = reinterpret_cast<XrSession>(std::uintptr_t{1});
    state.send(XR_SESSION_STATE_IDLE);
    state.send(XR_SESSION_STATE_READY);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL create_space(XrSession, const XrReferenceSpaceCreateInfo* wanted, XrSpace* space) {
    if (wanted->referenceSpaceType != XR_REFERENCE_SPACE_TYPE_LOCAL)
        return XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
    state.spaces.push_back(wanted->poseInReferenceSpace);
    *space = reinterpret_cast<XrSpace>(state.spaces.size());
    return XR_SUCCESS;
}

XrResult XRAPI_CALL create_swapchain(XrSession, const XrSwapchainCreateInfo* wanted, XrSwapchain* swapchain) {
    if (wanted->format != GL_SRGB8_ALPHA8 || wanted->width > 4096 || wanted->height > 2048)
        return XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
    state.make_images(int(wanted->width), int(wanted->height));
    *swapchain = reinterpret_cast<XrSwapchain>(std::uintptr_t{1});
    return XR_SUCCESS;
}

XrResult XRAPI_CALL images(XrSwapchain, std::uint32_t capacity, std::uint32_t* count, XrSwapchainImageBaseHeader* to) {
    *count = std::uint32_t(state.images.size());
    for (std::uint32_t i = 0; i < capacity && i < *count; ++i)
        reinterpret_cast<XrSwapchainImageOpenGLKHR*>(to)[i].image = state.images[i];
    return XR_SUCCESS;
}

XrResult XRAPI_CALL formats(XrSession, std::uint32_t capacity, std::uint32_t* count, std::int64_t* to) {
    constexpr std::int64_t known[] = {GL_RGBA16F, GL_SRGB8_ALPHA8};
    *count = 2;
    std::copy_n(known, std::min<std::uint32_t>(capacity, 2), to);
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
    return state.has_headset ? XR_SUCCESS : XR_ERROR_FORM_FACTOR_UNAVAILABLE;
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
    *count = 1;
    if (capacity > 0)
        std::strcpy(to[0].extensionName, XR_KHR_OPENGL_ENABLE_EXTENSION_NAME);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL create_instance(const XrInstanceCreateInfo*, XrInstance* instance) {
    *instance = reinterpret_cast<XrInstance>(std::uintptr_t{1});
    return state.load() ? XR_SUCCESS : XR_ERROR_RUNTIME_FAILURE;
}

XrResult XRAPI_CALL instance_properties(XrInstance, XrInstanceProperties* properties) {
    std::strcpy(properties->runtimeName, "fake");
    return XR_SUCCESS;
}

XrResult XRAPI_CALL destroy_instance(XrInstance) {
    state.close();
    return XR_SUCCESS;
}
XrResult XRAPI_CALL destroy_session(XrSession) {
    return XR_SUCCESS;
}
XrResult XRAPI_CALL destroy_space(XrSpace) {
    return XR_SUCCESS;
}
XrResult XRAPI_CALL destroy_swapchain(XrSwapchain) {
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
    };
    for (const Entry& entry : entries)
        if (std::strcmp(entry.name, name) == 0) {
            *function = entry.function;
            return XR_SUCCESS;
        }
    *function = nullptr;
    return XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace

XrResult negotiate(const LoaderInfo& loader, RuntimeRequest& runtime) {
    if (loader.min_interface > 1 || loader.max_interface < 1)
        return XR_ERROR_INITIALIZATION_FAILED;
    runtime.interface_version = 1;
    runtime.api_version = XR_CURRENT_API_VERSION;
    runtime.function_of = function_of;
    return XR_SUCCESS;
}

}  // namespace fake

extern "C" __attribute__((visibility("default"))) XrResult XRAPI_CALL
xrNegotiateLoaderRuntimeInterface(const fake::LoaderInfo* loader, fake::RuntimeRequest* runtime) {
    return fake::negotiate(*loader, *runtime);
}
