#include "fake_state.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

namespace fake {

bool State::load() {
    const char* where = std::getenv("EQUISTREAM_FAKE_XR");
    folder = where == nullptr ? "." : where;
    std::ifstream script(folder + "/script.txt");
    std::string line;
    while (std::getline(script, line)) {
        Frame next;
        XrPosef& head = next.head;
        std::istringstream words(line);
        const std::string until = "until ";
        if (line.starts_with(until) && !frames.empty()) {
            frames.back().until = line.substr(until.size());
        } else if (line == "loss" || line == "exit") {
            ends_by_loss = line == "loss";
        } else if (line == "no headset") {
            has_headset = false;
        } else if (line == "idle") {
            next.idle = true;
            frames.push_back(next);
        } else if (words >> head.position.x >> head.position.y >> head.position.z >> head.orientation.w >>
                   head.orientation.x >> head.orientation.y >> head.orientation.z) {
            frames.push_back(next);
        } else {
            return false;
        }
    }
    log.open(folder + "/log.jsonl");
    log.precision(9);
    return !frames.empty() || !has_headset;
}

void State::close() {
    log << "{\"end\": true, \"running\": " << running << ", \"spaces\": " << spaces.size() << "}" << std::endl;
}

bool State::go_on() {
    const std::string& until = frames[frame].until;
    if (!until.empty() && !std::filesystem::exists(folder + "/" + until))
        return true;
    const bool is_last = frame + 1 == frames.size();
    frame += is_last ? 0 : 1;
    return !is_last;
}

XrResult State::broken(const char* what) {
    log << "{\"broken\": \"" << what << "\"}" << std::endl;
    return XR_ERROR_CALL_ORDER_INVALID;
}

bool State::take(XrEventDataBuffer& event) {
    if (events.empty())
        return false;
    auto& changed = reinterpret_cast<XrEventDataSessionStateChanged&>(event);
    changed = {};
    changed.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED;
    changed.session = reinterpret_cast<XrSession>(std::uintptr_t{1});
    changed.state = events.front();
    events.pop_front();
    ready = ready || changed.state == XR_SESSION_STATE_READY;
    stopping = stopping || changed.state == XR_SESSION_STATE_STOPPING;
    return true;
}

void State::make_images(int columns, int rows) {
    width = columns;
    height = rows;
    images.assign(3, 0);
    glCreateTextures(GL_TEXTURE_2D, 3, images.data());
    for (const std::uint32_t name : images)
        glTextureStorage2D(name, 1, GL_SRGB8_ALPHA8, width, height);
}

bool State::record(const XrCompositionLayerProjection& layer) {
    std::vector<std::uint8_t> pixels(std::size_t(width) * std::size_t(height) * 3);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(images[image], 0, GL_RGB, GL_UNSIGNED_BYTE, GLsizei(pixels.size()), pixels.data());
    log << "{\"frame\": " << frame << ", \"swapchain\": [" << width << ", " << height << "], \"views\": [";
    for (std::uint32_t eye = 0; eye < layer.viewCount; ++eye) {
        const XrCompositionLayerProjectionView& view = layer.views[eye];
        const auto& [offset, extent] = view.subImage.imageRect;
        if (offset.x < 0 || offset.y < 0 || extent.width <= 0 || extent.height <= 0 ||
            offset.x + extent.width > width || offset.y + extent.height > height)
            return false;
        char name[32];
        std::snprintf(name, sizeof name, "frame.%04zu.%u.ppm", frame, eye);
        std::ofstream picture(folder + "/" + name, std::ios::binary);
        picture << "P6\n" << extent.width << ' ' << extent.height << "\n255\n";
        // Pictures begin at the top, textures at the bottom.
        for (int y = extent.height - 1; y >= 0; --y)
            picture.write(reinterpret_cast<const char*>(pixels.data()) +
                              3 * (std::ptrdiff_t(offset.y + y) * width + offset.x),
                          3 * extent.width);
        const auto& [q, p] = view.pose;
        log << (eye > 0 ? ", " : "") << "{\"rect\": [" << offset.x << ", " << offset.y << ", " << extent.width << ", "
            << extent.height << "], \"fov\": [" << view.fov.angleLeft << ", " << view.fov.angleRight << ", "
            << view.fov.angleUp << ", " << view.fov.angleDown << "], \"position\": [" << p.x << ", " << p.y << ", "
            << p.z << "], \"orientation\": [" << q.w << ", " << q.x << ", " << q.y << ", " << q.z << "]}";
    }
    log << "]}" << std::endl;
    return true;
}

}  // namespace fake
