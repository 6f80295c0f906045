#include "stage_times.h"

#include <client/timing/viewing.h>

#include <nlohmann/json.hpp>

namespace equistream::serve {

void StageTimes::add(LiveStage stage, double seconds) {
    std::deque<double>& of_stage = seconds_[std::size_t(stage)];
    of_stage.push_back(seconds);
    if (of_stage.size() > kept)
        of_stage.pop_front();
}

nlohmann::ordered_json StageTimes::json() const {
    nlohmann::ordered_json stages = nlohmann::ordered_json::object();
    for (std::size_t stage = 0; stage < seconds_.size(); ++stage) {
        const std::deque<double>& of_stage = seconds_[stage];
        if (of_stage.empty())
            continue;
        const Quantiles spread = quantiles_of({of_stage.begin(), of_stage.end()});
        stages[live_stage_names[stage]] = {{"p50", 1e3 * spread.median},
                                           {"p99", 1e3 * spread.p99},
                                           {"mean", 1e3 * spread.mean},
                                           {"samples", of_stage.size()}};
    }
    return stages;
}

}  // namespace equistream::serve
