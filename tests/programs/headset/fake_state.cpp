#include "fake_state.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace fake {

State state;

std::string script_folder() {
    const char* where = std::getenv("EQUISTREAM_FAKE_XR");
    return where == nullptr ? "." : where;
}

bool State::load() {
    folder = script_folder();
    log.open(folder + "/log.jsonl");
    log.precision(9);
    return script.read(folder + "/script.txt");
}

void State::close() {
    log << "{\"end\": true, \"running\": " << running << ", \"begun_sessions\": " << begun_sessions
        << ", \"spaces\": " << made_spaces << ", \"swapchains\": " << made_swapchains << "}" << std::endl;
}

bool State::is_there(const std::string& name) const {
    return std::filesystem::exists(folder + "/" + name);
}

void State::go_on() {
    const Frame shown = now();
    if (!shown.until.empty() && !is_there(shown.until))
        return;
    if (frame + 1 < script.frames.size())
        ++frame;
    if (shown.recentred_after > 0)
        send_recentred(shown.recentred_after);
    switch (shown.then) {
    case Then::next:
        break;
    case Then::stop:
        ready_until = shown.ready_until;
        send(XR_SESSION_STATE_STOPPING);
        break;
    case Then::exit:
        exits = true;
        send(XR_SESSION_STATE_STOPPING);
        break;
    case Then::loss:
        send(XR_SESSION_STATE_LOSS_PENDING);
        break;
    case Then::instance_loss: {
        XrEventDataInstanceLossPending pending{};
        pending.type = XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING;
        send(pending);
        break;
    }
    case Then::lost_call:
        lost = true;
        break;
    }
}

/// Of another space too, which nobody here has, and which begins anew at once.
void State::send_recentred(int frames_on) {
    XrEventDataReferenceSpaceChangePending change{};
    change.type = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING;
    change.session = session_handle;
    change.poseInPreviousSpace = {{0, 0, 0, 1}, {0, 0, 0}};
    change.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
    change.changeTime = display_time + frames_on * period_ns;
    send(change);
    change.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_STAGE;
    change.changeTime = 0;
    send(change);
}

XrResult State::broken(const char* what, XrResult why) {
    log << "{\"broken\": \"" << what << "\"}" << std::endl;
    return why;
}

void State::send(XrSessionState next) {
    XrEventDataSessionStateChanged changed{};
    changed.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED;
    changed.session = session_handle;
    changed.state = next;
    send(changed);
}

bool State::take(XrEventDataBuffer& event) {
    if (events.empty())
        return false;
    const auto& next = reinterpret_cast<const XrEventDataSessionStateChanged&>(events.front());
    if (next.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
        if (next.state == XR_SESSION_STATE_READY && !ready_until.empty() && !is_there(ready_until))
            return false;
        ready = ready || next.state == XR_SESSION_STATE_READY;
        stopping = stopping || next.state == XR_SESSION_STATE_STOPPING;
    }
    event = events.front();
    events.pop_front();
    return true;
}

long State::pictures() const {
    return std::ranges::count_if(std::filesystem::recursive_directory_iterator(folder),
                                 [](const auto& entry) { return entry.path().extension() == ".png"; });
}

bool State::record(const XrCompositionLayerProjection& layer) {
    log << "{\"frame\": " << frame << ", \"pictures\": [" << pictures_at_begin << ", " << pictures()
        << "], \"views\": [";
    for (std::uint32_t eye = 0; eye < layer.viewCount; ++eye) {
        const XrCompositionLayerProjectionView& view = layer.views[eye];
        const auto found = swapchains.find(reinterpret_cast<std::uintptr_t>(view.subImage.swapchain));
        if (found == swapchains.end())
            return false;
        const Swapchain& chain = found->second;
        std::vector<std::uint8_t> pixels(std::size_t(chain.width) * std::size_t(chain.height) * 3);
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glGetTextureImage(chain.images[chain.image], 0, GL_RGB, GL_UNSIGNED_BYTE, GLsizei(pixels.size()),
                          pixels.data());
        const auto& [offset, extent] = view.subImage.imageRect;
        if (offset.x < 0 || offset.y < 0 || extent.width <= 0 || extent.height <= 0 ||
            offset.x + extent.width > chain.width || offset.y + extent.height > chain.height)
            return false;
        char name[32];
        std::snprintf(name, sizeof name, "frame.%04zu.%u.ppm", frame, eye);
        std::ofstream picture(folder + "/" + name, std::ios::binary);
        picture << "P6\n" << extent.width << ' ' << extent.height << "\n255\n";
        // Pictures begin at the top, textures at the bottom.
        for (int y = extent.height - 1; y >= 0; --y)
            picture.write(reinterpret_cast<const char*>(pixels.data()) +
                              3 * (std::ptrdiff_t(offset.y + y) * chain.width + offset.x),
                          3 * extent.width);
        const auto& [q, p] = view.pose;
        log << (eye > 0 ? ", " : "") << "{\"rect\": [" << offset.x << ", " << offset.y << ", " << extent.width << ", "
            << extent.height << "], \"fov\": [" << view.fov.angleLeft << ", " << view.fov.angleRight << ", "
            << view.fov.angleUp << ", " << view.fov.angleDown << "], \"position\": [" << p.x << ", " << p.y << ", "
            << p.z << "], \"orientation\": [" << q.w << ", " << q.x << ", " << q.y << ", " << q.z
            << "], \"swapchain\": [" << chain.width << ", " << chain.height << "]}";
    }
    log << "]}" << std::endl;
    return true;
}

}  // namespace fake
