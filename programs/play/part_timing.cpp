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

PartTimes FramePlayer::parts_of_frame(const ReceivedFrame& frame, const PipelineTimes& times) const {
    PartTimes parts = parts_with_decoding(frame);
    if (takes_depth())
        parts[part::depth(plan_)] += times.depth - times.small_depth - times.patches_depth;
    if (times.small_depth > 0)
        parts[part::depth_of(plan_, "small")] += times.small_depth;
    if (times.patches_depth > 0)
        parts[part::depth_of(plan_, "patches")] += times.patches_depth;
    parts[part::reproject(plan_)] = times.reproject;
    if (settings_.reliability)
        parts[part::reliability()] = times.reliability;
    // Passes of both eyes run side by side: each takes its share of what all took.
    const double all_ms = std::accumulate(times.passes.begin(), times.passes.end(), 0.0);
    const std::vector<std::string> names = pipeline_.fill().names();
    for (std::size_t i = 0; all_ms > 0 && i < times.passes.size(); ++i)
        parts[part::fill(plan_, names[i])] += times.fill * times.passes[i] / all_ms;
    return parts;
}

}  // namespace equistream::play
