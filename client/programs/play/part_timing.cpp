/// FramePlayer's times by part (plan_times.h).
#include "frame_player.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace equistream::play {

PartTimes FramePlayer::parts_with_decoding(const ReceivedFrame& frame) const {
    PartTimes parts;
    for (const Part& part : parts_of(plan_))
        parts[part] = 0;
    const auto decoding_ms = [](const ReceivedPicture& picture) { return picture.decode_ms + picture.convert_ms; };
    parts[part::frame()] = decoding_ms(frame.main);
    for (const auto& [name, picture] :
         {std::pair{"small", &frame.small}, {"hidden", &frame.hidden}, {"patches", &frame.patches}}) {
        const auto part = parts.find(is_settled_ ? part::frame() : part::track(name));
        if (*picture && part != parts.end())
            part->second += decoding_ms(**picture);
    }
    return parts;
}

void FramePlayer::add_filling(std::span<const double> left_ms, std::span<const double> right_ms, double ms) {
    const std::span<const double> shared_ms = fill_->set_frame_ms();
    std::vector<double> rungs_ms(shared_ms.begin(), shared_ms.end());
    for (std::size_t i = 0; i < rungs_ms.size(); ++i)
        rungs_ms[i] += std::max(left_ms[i], right_ms[i]);
    const double all_ms = std::accumulate(rungs_ms.begin(), rungs_ms.end(), 0.0);
    if (all_ms <= 0)
        return;
    const std::vector<std::string> names = fill_->names();
    for (std::size_t i = 0; i < rungs_ms.size(); ++i)
        parts_[part::fill(plan_, names[i])] += ms * rungs_ms[i] / all_ms;
}

}  // namespace equistream::play
