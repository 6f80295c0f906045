#include "rungs.h"

#include <equistream/error.h>
#include <equistream_client/stages.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace equistream::gl {

namespace {

/// Rows of the stages table that are on the GPU.
constexpr std::array<std::pair<std::string_view, Rung>, 5> made = {{{"hidden", Rung::hidden},
                                                                    {"patches", Rung::patches},
                                                                    {"earlier", Rung::earlier},
                                                                    {"small", Rung::small},
                                                                    {"pushpull", Rung::push_pull}}};

}  // namespace

std::vector<Rung> parse_rungs(const std::string& list) {
    std::vector<Rung> rungs;
    for (const FillStage* stage : parse_fills(list)) {
        const auto found = std::ranges::find(made, stage->name, &std::pair<std::string_view, Rung>::first);
        assert(stage->on_gpu == (found != made.end()));
        if (found == made.end())
            throw InputError(
                expected_found("--fill", "passes that the viewer has", "'" + std::string(stage->name) + "'"));
        rungs.push_back(found->second);
    }
    return rungs;
}

std::string with_rungs_of_gpu(const std::string& list, std::vector<std::string>& notes) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 3> instead = {
        {{"small-wide", "small"}, {"spread", "pushpull"}, {"geometry", ""}}};
    std::string rungs;
    for (const std::string_view word : split_at_commas(list)) {
        const auto found = std::ranges::find(instead, word, [](const auto& pair) { return pair.first; });
        const std::string_view taken = found == instead.end() ? word : found->second;
        if (found != instead.end())
            notes.push_back("--fill " + std::string(word) + " is of play alone: " +
                            (taken.empty() ? "it is passed over" : std::string(taken) + " is taken"));
        if (!taken.empty())
            rungs += (rungs.empty() ? "" : ",") + std::string(taken);
    }
    return rungs.empty() ? "none" : rungs;
}

}  // namespace equistream::gl
