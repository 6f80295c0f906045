#include "truth.h"

#include <equistream/error.h>
#include <equistream_client/receive.h>

#include <cmath>
#include <optional>
#include <utility>
#include <variant>

namespace equistream {

namespace {

constexpr std::array<const char*, 2> eye_folders = {"left", "right"};

}  // namespace

Truth::Truth(const std::filesystem::path& folder) : folder_(folder) {
    for (std::size_t eye = 0; eye < feeds_.size(); ++eye)
        if (std::filesystem::is_directory(folder_ / eye_folders[eye]))
            feeds_[eye] = open_feed((folder_ / eye_folders[eye]).string());
    bool any = false;
    for (std::size_t eye = 0; eye < feeds_.size(); ++eye)
        if (feeds_[eye] && read(eye, 0) && !std::exchange(any, true)) {
            camera_ = eyes_.camera;
            first_s_ = eyes_.time_s;
            first_index_ = eyes_.index;
        }
    if (!any)
        throw InputError(expected_found(
            folder_.string(), "a folder left or right of eyes (render --camera perspective --eye both)", "neither"));
    eyes_ = {};
}

/// The first frame from that one on; false: there is none.
bool Truth::read(std::size_t eye, std::int64_t index) {
    if (!feeds_[eye]->seek(index))
        return false;
    std::optional<ReceivedFrame> frame = feeds_[eye]->next();
    if (!frame)
        return false;
    const FrameInfo& info = frame->main.info;
    const auto* camera = std::get_if<PerspectiveCamera>(&info.camera);
    if (camera == nullptr)
        throw InputError(expected_found((folder_ / eye_folders[eye]).string(),
                                        "eyes that render --camera perspective wrote", "spheres"));
    frames_per_second_ = info.frames_per_second;
    if (eyes_.index != info.index)
        eyes_ = {};
    eyes_.index = info.index;
    eyes_.time_s = info.time_s;
    eyes_.ipd_m = info.ipd_m;
    eyes_.head = info.head;
    eyes_.camera = *camera;
    eyes_.rgb[eye] = std::move(frame->main.rgb);
    return true;
}

const TrueEyes* Truth::at(double time_s) {
    const auto index = first_index_ + std::int64_t(std::llround((time_s - first_s_) * frames_per_second_));
    if (eyes_.index != index) {
        eyes_ = {};
        for (std::size_t eye = 0; eye < feeds_.size(); ++eye)
            if (feeds_[eye])
                read(eye, index);
    }
    return eyes_.index == index && std::abs(eyes_.time_s - time_s) <= 0.5 / frames_per_second_ ? &eyes_ : nullptr;
}

}  // namespace equistream
