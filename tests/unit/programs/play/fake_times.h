#pragma once
/// Machines that plans are played on in tests of choices: what each part of the work takes, and no clock.
#include <programs/play/choice.h>

#include <random>

namespace equistream::play::fakes {

/// Each part takes what it takes, whatever it is played with; a mesh's cells as much as there are of them, and some
/// work goes on beside them.
class FakeMachine {
public:
    explicit FakeMachine(unsigned seed) : random_(seed) {}

    PartTimes times(const Plan& plan) {
        PartTimes times;
        for (const Part& part : parts_of(plan)) {
            if (!costs_.contains(part.name))
                costs_[part.name] = {1 + double(random_() % 400) / 10, double(random_() % 100) / 10};
            const auto& [fixed_ms, cells_ms] = costs_[part.name];
            times[part] = part.mesh_share > 0 ? fixed_ms + cells_ms / part.mesh_share : fixed_ms;
        }
        return times;
    }
    double milliseconds(const Plan& plan) { return total_ms(times(plan)); }
    void set(const std::string& part, double fixed_ms, double cells_ms = 0) { costs_[part] = {fixed_ms, cells_ms}; }

private:
    std::mt19937 random_;
    std::map<std::string, std::pair<double, double>> costs_;
};

/// All that there can be to choose from, with ladders of several rungs, of one and of none.
inline std::vector<PlanInputs> all_inputs() {
    std::vector<PlanInputs> all;
    for (const char* fill :
         {"hidden,patches,earlier,small,small-wide,geometry,pushpull", "patches,small,pushpull", "pushpull", "none"})
        for (const unsigned there : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u})
            all.push_back({.geometry = (there & 1) != 0,
                           .streamed_depth = (there & 2) != 0,
                           .poses = (there & 4) != 0,
                           .fill = fill});
    return all;
}

}  // namespace equistream::play::fakes
