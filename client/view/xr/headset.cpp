#include "headset.h"

#include "xr_calls.h"

#include <equistream/error.h>

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

using xr::check;

struct Headset::Handles {
    ~Handles() {
        // Children go with their parents.
        if (session != XR_NULL_HANDLE)
            xrDestroySession(session);
        if (instance != XR_NULL_HANDLE)
            xrDestroyInstance(instance);
    }

    XrInstance instance = XR_NULL_HANDLE;
    XrSystemId system = XR_NULL_SYSTEM_ID;
    XrSession session = XR_NULL_HANDLE;
    XrSpace space = XR_NULL_HANDLE;
    XrSwapchain swapchain = XR_NULL_HANDLE;
    XrEnvironmentBlendMode blend = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    std::vector<XrSwapchainImageOpenGLKHR> images;
    std::vector<gl::Framebuffer> framebuffers;
    std::optional<xr::RuntimeClock> clock;
    XrTime display_time = 0;
    XrDuration period = 0;               ///< from one frame's time to the next
    std::optional<XrTime> recentred_at;  ///< from then on the runtime's space is another
    std::array<XrView, 2> views{};
};

void Headset::be_quiet() {
    setenv("XR_LOADER_DEBUG", "none", 0);
}

Headset::Headset() : handles_(std::make_unique<Handles>()) {
    handles_->instance = xr::create_instance();
    find_system();
    handles_->session = xr::create_session(handles_->instance, handles_->system);
    xr::require_our_format(handles_->session);
    handles_->clock.emplace(handles_->instance);
    create_space();
}

Headset::~Headset() = default;

void Headset::find_system() {
    Handles& h = *handles_;
    auto wanted = xr::made<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
    wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    const XrResult found = xrGetSystem(h.instance, &wanted, &h.system);
    if (XR_FAILED(found))
        throw InputError(expected_found("--headset", "a headset", xr::name_of(found)));
    auto properties = xr::made<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    check(xrGetSystemProperties(h.instance, h.system, &properties), "xrGetSystemProperties");
    const auto views = xr::list<XrViewConfigurationView>(
        xr::made<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW), "xrEnumerateViewConfigurationViews",
        [&](std::uint32_t capacity, std::uint32_t* count, XrViewConfigurationView* to) {
            return xrEnumerateViewConfigurationViews(h.instance, h.system, xr::stereo, capacity, count, to);
        });
    if (views.size() != 2)
        throw InputError(expected_found("--headset", "two eyes", std::to_string(views.size())));
    columns_ = int(views[0].recommendedImageRectWidth);
    most_ = {int(std::min(views[0].maxImageRectWidth, properties.graphicsProperties.maxSwapchainImageWidth / 2)),
             int(std::min(views[0].maxImageRectHeight, properties.graphicsProperties.maxSwapchainImageHeight))};
    const auto blends = xr::list<XrEnvironmentBlendMode>(
        {}, "xrEnumerateEnvironmentBlendModes",
        [&](std::uint32_t capacity, std::uint32_t* count, XrEnvironmentBlendMode* to) {
            return xrEnumerateEnvironmentBlendModes(h.instance, h.system, xr::stereo, capacity, count, to);
        });
    if (!blends.empty() && std::ranges::find(blends, h.blend) == blends.end())
        h.blend = blends.front();
}

void Headset::create_space() {
    Handles& h = *handles_;
    if (h.space != XR_NULL_HANDLE)
        xrDestroySpace(h.space);
    auto wanted = xr::made<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
    wanted.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
    wanted.poseInReferenceSpace = xr::from_pose(centre_);
    check(xrCreateReferenceSpace(h.session, &wanted, &h.space), "xrCreateReferenceSpace");
}

void Headset::recentre() {
    if (!head_)
        return;
    const glm::dvec3 ahead = head_->orientation * glm::dvec3(0, 0, -1);
    // Straight up or down there is no ahead.
    const double yaw_rad = std::hypot(ahead.x, ahead.z) > 1e-3 ? std::atan2(-ahead.x, -ahead.z) : 0;
    centre_.position_m += centre_.orientation * head_->position_m;
    centre_.orientation = glm::normalize(centre_.orientation * glm::angleAxis(yaw_rad, glm::dvec3(0, 1, 0)));
    create_space();
    head_.reset();
}

/// What was centred by us was so in the space that is no more.
void Headset::centre_with_runtime() {
    handles_->recentred_at.reset();
    centre_ = {};
    create_space();
    head_.reset();
}

void Headset::begin_session() {
    auto begin = xr::made<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
    begin.primaryViewConfigurationType = xr::stereo;
    check(xrBeginSession(handles_->session, &begin), "xrBeginSession");
    running_ = true;
}

void Headset::poll() {
    for (;;) {
        auto event = xr::made<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
        const XrResult result = xrPollEvent(handles_->instance, &event);
        if (result == XR_EVENT_UNAVAILABLE)
            return;
        check(result, "xrPollEvent");
        if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING)
            throw WorkError(xr::lost);
        if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING) {
            const auto& change = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(event);
            if (change.referenceSpaceType == XR_REFERENCE_SPACE_TYPE_LOCAL)
                handles_->recentred_at = change.changeTime;
        }
        if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
            continue;
        switch (reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state) {
        case XR_SESSION_STATE_READY:
            begin_session();
            break;
        case XR_SESSION_STATE_STOPPING:
            running_ = false;
            check(xrEndSession(handles_->session), "xrEndSession");
            break;
        case XR_SESSION_STATE_EXITING:
            over_ = true;
            break;
        case XR_SESSION_STATE_LOSS_PENDING:
            throw WorkError(xr::lost);
        default:
            break;
        }
    }
}

std::optional<HeadsetView> Headset::begin_frame() {
    Handles& h = *handles_;
    auto state = xr::made<XrFrameState>(XR_TYPE_FRAME_STATE);
    check(xrWaitFrame(h.session, nullptr, &state), "xrWaitFrame");
    check(xrBeginFrame(h.session, nullptr), "xrBeginFrame");
    h.display_time = state.predictedDisplayTime;
    h.period = state.predictedDisplayPeriod;
    if (h.recentred_at && h.display_time >= *h.recentred_at)
        centre_with_runtime();
    seen_ = state.shouldRender == XR_TRUE ? locate() : std::nullopt;
    if (seen_)
        create_swapchain(seen_->view);
    return seen_;
}

/// Nothing until it is tracked.
std::optional<HeadsetView> Headset::locate() {
    Handles& h = *handles_;
    auto where = xr::made<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
    where.viewConfigurationType = xr::stereo;
    where.displayTime = h.display_time;
    where.space = h.space;
    auto known = xr::made<XrViewState>(XR_TYPE_VIEW_STATE);
    h.views.fill(xr::made<XrView>(XR_TYPE_VIEW));
    std::uint32_t count = 0;
    check(xrLocateViews(h.session, &where, &known, 2, &count, h.views.data()), "xrLocateViews");
    constexpr XrViewStateFlags both = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
    if (count != 2 || (known.viewStateFlags & both) != both)
        return std::nullopt;
    HeadsetView seen;
    std::array<FieldOfView, 2> fovs;
    for (std::size_t i = 0; i < 2; ++i) {
        seen.eyes[i] = xr::to_pose(h.views[i].pose);
        const XrFovf& fov = h.views[i].fov;
        fovs[i] = {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown};
    }
    seen.head.position_m = 0.5 * (seen.eyes[0].position_m + seen.eyes[1].position_m);
    seen.head.orientation = glm::slerp(seen.eyes[0].orientation, seen.eyes[1].orientation, 0.5);
    seen.view = covering_view(fovs, columns_, {most_.width, most_.height});
    seen.until_seen_s = std::max(0.0, h.clock->seconds_until(h.display_time).value_or(1e-9 * double(h.period)));
    head_ = seen.head;
    return seen;
}

void Headset::create_swapchain(const CoveringView& view) {
    const gl::Size size{2 * view.camera.width, view.camera.height};
    Handles& h = *handles_;
    if (size == size_)
        return;
    h.framebuffers.clear();
    h.images.clear();
    if (h.swapchain != XR_NULL_HANDLE)
        check(xrDestroySwapchain(std::exchange(h.swapchain, XR_NULL_HANDLE)), "xrDestroySwapchain");
    h.swapchain = xr::create_swapchain(h.session, size);
    h.images = xr::list<XrSwapchainImageOpenGLKHR>(
        xr::made<XrSwapchainImageOpenGLKHR>(XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR), "xrEnumerateSwapchainImages",
        [&](std::uint32_t capacity, std::uint32_t* count, XrSwapchainImageOpenGLKHR* to) {
            return xrEnumerateSwapchainImages(h.swapchain, capacity, count,
                                              reinterpret_cast<XrSwapchainImageBaseHeader*>(to));
        });
    for (const XrSwapchainImageOpenGLKHR& image : h.images) {
        GLuint name = 0;
        glCreateFramebuffers(1, &name);
        h.framebuffers.emplace_back(name);
        glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, image.image, 0);
        gl::require_complete(h.framebuffers.back());
    }
    size_ = size;
}

GLuint Headset::framebuffer() {
    if (acquired_ < 0)
        acquire();
    return handles_->framebuffers.at(std::size_t(acquired_)).name();
}

void Headset::acquire() {
    std::uint32_t index = 0;
    check(xrAcquireSwapchainImage(handles_->swapchain, nullptr, &index), "xrAcquireSwapchainImage");
    auto wait = xr::made<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
    wait.timeout = XR_INFINITE_DURATION;
    check(xrWaitSwapchainImage(handles_->swapchain, &wait), "xrWaitSwapchainImage");
    acquired_ = int(index);
}

void Headset::end_frame() {
    Handles& h = *handles_;
    auto layer = xr::made<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
    std::array<XrCompositionLayerProjectionView, 2> views{};
    const bool drawn = seen_ && acquired_ >= 0;
    if (drawn) {
        check(xrReleaseSwapchainImage(h.swapchain, nullptr), "xrReleaseSwapchainImage");
        acquired_ = -1;
        for (std::size_t i = 0; i < views.size(); ++i) {
            const ViewPart& part = seen_->view.parts[i];
            XrCompositionLayerProjectionView& view = views[i];
            view.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW;
            view.pose = h.views[i].pose;
            view.fov = {float(part.fov.left_rad), float(part.fov.right_rad), float(part.fov.up_rad),
                        float(part.fov.down_rad)};
            view.subImage.swapchain = h.swapchain;
            // Rows are counted from the bottom.
            view.subImage.imageRect = {{part.left + int(i) * size_.width / 2, size_.height - part.top - part.height},
                                       {part.width, part.height}};
        }
        layer.space = h.space;
        layer.viewCount = 2;
        layer.views = views.data();
    }
    const auto* base = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer);
    auto end = xr::made<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
    end.displayTime = h.display_time;
    end.environmentBlendMode = h.blend;
    end.layerCount = drawn ? 1 : 0;
    end.layers = &base;
    seen_.reset();
    check(xrEndFrame(h.session, &end), "xrEndFrame");
}

}  // namespace equistream
