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
constexpr std::array<std::pair<std::string_view, Rung>, 8> made = {{{"hidden", Rung::hidden},
                                                                    {"patches", Rung::patches},
                                                                    {"earlier", Rung::earlier},
                                                                    {"small", Rung::small},
                                                                    {"small-wide", Rung::small_wide},
                                                                    {"geometry", Rung::geometry},
                                                                    {"pushpull", Rung::push_pull},
                                                                    {"spread", Rung::spread}}};

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

}  // namespace equistream::gl
