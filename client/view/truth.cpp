#include "truth.h"

#include <equistream/error.h>

#include <cmath>
#include <variant>

namespace equistream {

constexpr std::array<const char*, 2> eye_folders = {"left", "right"};

Truth::Truth(const std::filesystem::path& folder) : folder_(folder) {
    for (std::size_t eye = feeds_.size(); eye-- > 0;) {
        if (!std::filesystem::is_directory(folder_ / eye_folders[eye]))
            continue;
        feeds_[eye] = open_feed((folder_ / eye_folders[eye]).string());
        const std::optional<ReceivedFrame> first = feeds_[eye]->next();
        if (!first)
            continue;
        first_index_ = first->main.info.index;
        first_s_ = first->main.info.time_s;
        frames_per_second_ = first->main.info.frames_per_second;
        wanted_ = {eye, first_index_};
        read_[wanted_].eye = read(wanted_);
        camera_ = read_[wanted_].eye->camera;
    }
    if (read_.empty())
        throw InputError(expected_found(
            folder_.string(), "views in left/ or right/ (render --camera perspective --eye both)", "neither"));
    thread_ = std::thread([this] { run(); });
}

Truth::~Truth() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

/// Null: there is none.
std::shared_ptr<const TrueEye> Truth::read(const Place& place) {
    const auto [eye, index] = place;
    if (!feeds_[eye] || !feeds_[eye]->seek(index))
        return nullptr;
    std::optional<ReceivedFrame> frame = feeds_[eye]->next();
    if (!frame || frame->main.info.index != index)
        return nullptr;
    const FrameInfo& info = frame->main.info;
    const auto* camera = std::get_if<PerspectiveCamera>(&info.camera);
    if (camera == nullptr)
        throw InputError(expected_found((folder_ / eye_folders[eye]).string(),
                                        "perspective views (render --camera perspective)", "spheres"));
    return std::make_shared<const TrueEye>(
        TrueEye{info.time_s, info.ipd_m, info.head, *camera, std::move(frame->main.rgb)});
}

bool Truth::is_wanted(const Place& place) const {
    return place.first == wanted_.first && place.second >= wanted_.second &&
           place.second <= wanted_.second + frames_ahead;
}

std::optional<Truth::Place> Truth::next_to_read() const {
    for (Place place = wanted_; is_wanted(place); ++place.second)
        if (!read_.contains(place))
            return place;
    return std::nullopt;
}

void Truth::run() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        const std::optional<Place> place = next_to_read();
        if (!place) {
            changed_.wait(lock);
            continue;
        }
        lock.unlock();
        Slot slot;
        try {
            slot.eye = read(*place);
        } catch (const std::exception& error) {
            slot.problem = error.what();
        }
        lock.lock();
        read_[*place] = std::move(slot);
        std::erase_if(read_, [this](const auto& entry) { return !is_wanted(entry.first); });
    }
}

Truth::Found Truth::at(double time_s, Eye eye) {
    const Place place{eye == Eye::right ? 1 : 0,
                      first_index_ + std::int64_t(std::llround((time_s - first_s_) * frames_per_second_))};
    const std::unique_lock lock(mutex_);
    if (wanted_ != place) {
        wanted_ = place;
        changed_.notify_all();
    }
    const auto found = read_.find(place);
    if (found == read_.end())
        return {.eye = nullptr, .is_coming = true, .problem = {}};
    const Slot& slot = found->second;
    const bool is_near = slot.eye && std::abs(slot.eye->time_s - time_s) <= 0.5 / frames_per_second_;
    return {.eye = is_near ? slot.eye : nullptr, .is_coming = false, .problem = slot.problem};
}

}  // namespace equistream
