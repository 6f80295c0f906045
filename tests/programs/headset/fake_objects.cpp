#include "fake_objects.h"

#include <algorithm>
#include <string>

namespace fake {

namespace {

Swapchain* swapchain_of(XrSwapchain handle) {
    const auto found = state.swapchains.find(reinterpret_cast<std::uintptr_t>(handle));
    return found == state.swapchains.end() ? nullptr : &found->second;
}

}  // namespace

bool is_gone(XrSession session) {
    return session != session_handle || !state.has_session;
}

XrResult gone(const char* call) {
    return state.broken((std::string(call) + " of what is not there").c_str(), XR_ERROR_HANDLE_INVALID);
}

bool is_any_acquired() {
    return std::ranges::any_of(state.swapchains, [](const auto& entry) { return entry.second.acquired; });
}

XrResult XRAPI_CALL create_space(XrSession session, const XrReferenceSpaceCreateInfo* wanted, XrSpace* space) {
    if (is_gone(session))
        return gone("xrCreateReferenceSpace");
    if (wanted->referenceSpaceType != XR_REFERENCE_SPACE_TYPE_LOCAL)
        return XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
    const std::uintptr_t handle = state.new_handle();
    state.spaces[handle] = wanted->poseInReferenceSpace;
    ++state.made_spaces;
    *space = reinterpret_cast<XrSpace>(handle);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL create_swapchain(XrSession session, const XrSwapchainCreateInfo* wanted, XrSwapchain* swapchain) {
    if (is_gone(session))
        return gone("xrCreateSwapchain");
    if (wanted->format != GL_SRGB8_ALPHA8 || !state.script.has_srgb)
        return state.broken("a swapchain of a format that there is not", XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED);
    if (wanted->width > 4096 || wanted->height > 2048)
        return XR_ERROR_SIZE_INSUFFICIENT;
    // It is drawn to, and copied to the window.
    if (wanted->usageFlags != (XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT))
        return state.broken("a swapchain for another use", XR_ERROR_FEATURE_UNSUPPORTED);
    const std::uintptr_t handle = state.new_handle();
    Swapchain& chain = state.swapchains[handle];
    chain.width = int(wanted->width);
    chain.height = int(wanted->height);
    chain.images.assign(3, 0);
    glCreateTextures(GL_TEXTURE_2D, 3, chain.images.data());
    for (const std::uint32_t name : chain.images)
        glTextureStorage2D(name, 1, GL_SRGB8_ALPHA8, chain.width, chain.height);
    ++state.made_swapchains;
    *swapchain = reinterpret_cast<XrSwapchain>(handle);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL images(XrSwapchain handle, std::uint32_t capacity, std::uint32_t* count,
                           XrSwapchainImageBaseHeader* to) {
    const Swapchain* const chain = swapchain_of(handle);
    if (chain == nullptr)
        return gone("xrEnumerateSwapchainImages");
    *count = std::uint32_t(chain->images.size());
    for (std::uint32_t i = 0; i < capacity && i < *count; ++i)
        reinterpret_cast<XrSwapchainImageOpenGLKHR*>(to)[i].image = chain->images[i];
    return XR_SUCCESS;
}

XrResult XRAPI_CALL formats(XrSession session, std::uint32_t capacity, std::uint32_t* count, std::int64_t* to) {
    if (is_gone(session))
        return gone("xrEnumerateSwapchainFormats");
    const std::int64_t known[] = {GL_RGBA16F, state.script.has_srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8};
    *count = 2;
    std::copy_n(known, std::min<std::uint32_t>(capacity, 2), to);
    return XR_SUCCESS;
}

XrResult XRAPI_CALL acquire(XrSwapchain handle, const XrSwapchainImageAcquireInfo*, std::uint32_t* index) {
    Swapchain* const chain = swapchain_of(handle);
    if (chain == nullptr)
        return gone("xrAcquireSwapchainImage");
    if (!state.begun || chain->acquired)
        return state.broken("xrAcquireSwapchainImage out of turn");
    chain->acquired = true;
    *index = chain->image = (chain->image + 1) % std::uint32_t(chain->images.size());
    return XR_SUCCESS;
}

XrResult XRAPI_CALL wait_image(XrSwapchain handle, const XrSwapchainImageWaitInfo*) {
    Swapchain* const chain = swapchain_of(handle);
    if (chain == nullptr)
        return gone("xrWaitSwapchainImage");
    if (!chain->acquired || chain->waited)
        return state.broken("xrWaitSwapchainImage out of turn");
    chain->waited = true;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL release(XrSwapchain handle, const XrSwapchainImageReleaseInfo*) {
    Swapchain* const chain = swapchain_of(handle);
    if (chain == nullptr)
        return gone("xrReleaseSwapchainImage");
    if (!chain->waited)
        return state.broken("xrReleaseSwapchainImage out of turn");
    chain->acquired = chain->waited = false;
    return XR_SUCCESS;
}

XrResult XRAPI_CALL destroy_space(XrSpace handle) {
    return state.spaces.erase(reinterpret_cast<std::uintptr_t>(handle)) == 1 ? XR_SUCCESS : gone("xrDestroySpace");
}

XrResult XRAPI_CALL destroy_swapchain(XrSwapchain handle) {
    const Swapchain* const chain = swapchain_of(handle);
    if (chain == nullptr)
        return gone("xrDestroySwapchain");
    if (chain->acquired)
        return state.broken("xrDestroySwapchain while an image is acquired");
    glDeleteTextures(GLsizei(chain->images.size()), chain->images.data());
    state.swapchains.erase(reinterpret_cast<std::uintptr_t>(handle));
    return XR_SUCCESS;
}

}  // namespace fake
