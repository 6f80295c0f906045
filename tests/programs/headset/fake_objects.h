#pragma once
/// Spaces and swapchains of the runtime for tests: OpenXR's own calls.
#include "fake_state.h"

namespace fake {

XrResult XRAPI_CALL acquire(XrSwapchain handle, const XrSwapchainImageAcquireInfo*, std::uint32_t* index);
XrResult XRAPI_CALL wait_image(XrSwapchain handle, const XrSwapchainImageWaitInfo*);
XrResult XRAPI_CALL release(XrSwapchain handle, const XrSwapchainImageReleaseInfo*);
XrResult XRAPI_CALL create_space(XrSession session, const XrReferenceSpaceCreateInfo* wanted, XrSpace* space);
XrResult XRAPI_CALL create_swapchain(XrSession session, const XrSwapchainCreateInfo* wanted, XrSwapchain* swapchain);
XrResult XRAPI_CALL images(XrSwapchain handle, std::uint32_t capacity, std::uint32_t* count,
                           XrSwapchainImageBaseHeader* to);
XrResult XRAPI_CALL formats(XrSession session, std::uint32_t capacity, std::uint32_t* count, std::int64_t* to);
XrResult XRAPI_CALL destroy_space(XrSpace handle);
XrResult XRAPI_CALL destroy_swapchain(XrSwapchain handle);

bool is_gone(XrSession session);
XrResult gone(const char* call);
bool is_any_acquired();

}  // namespace fake
