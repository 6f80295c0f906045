/// The stages table's OpenGL column.
#include "stages.h"

#include <client/fill/gl/fill_pass.h>
#include <client/warp/gl/eye_depth_finder.h>

#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <utility>

namespace equistream::gl {

#define ENGINE(name, old_name, help, needs, finds_depth, on_cpu, on_gpu)                                               \
    std::unique_ptr<EyeDepthFinder> on_gpu(const EngineOptions&);
#define FILL_PASS(name, help, reads, needs_depth, invents, left_out, on_cpu, on_gpu)                                   \
    std::unique_ptr<GlFillPass> on_gpu(GlFillShared&);
#include "stage_rows.inc"
#undef ENGINE
#undef FILL_PASS

namespace {

template <typename Make>
struct GlRow {
    std::string_view name;
    Make make;  ///< null: it is not on the GPU
};
using MakeFinder = std::unique_ptr<EyeDepthFinder> (*)(const EngineOptions&);
using MakePass = std::unique_ptr<GlFillPass> (*)(GlFillShared&);

#define ENGINE(name, old_name, help, needs, finds_depth, on_cpu, on_gpu)                                               \
    GlRow<MakeFinder>{name, std::string_view(#on_gpu) == "none" ? nullptr : static_cast<MakeFinder>(on_gpu)},
constexpr std::array finders = {
#include "stage_rows.inc"
};
#undef ENGINE

#define FILL_PASS(name, help, reads, needs_depth, invents, left_out, on_cpu, on_gpu)                                   \
    GlRow<MakePass>{name, std::string_view(#on_gpu) == "none" ? nullptr : static_cast<MakePass>(on_gpu)},
constexpr std::array passes = {
#include "stage_rows.inc"
};
#undef FILL_PASS

template <typename Rows>
auto make_of(const Rows& rows, const equistream::Stage& stage, std::string_view option) {
    require_on_gpu(stage, option);
    return std::ranges::find_if(rows, [&](const auto& each) { return each.name == stage.name; })->make;
}

}  // namespace

std::unique_ptr<EyeDepthFinder> resample_alone(const EngineOptions&) {
    return nullptr;
}

std::unique_ptr<EyeDepthFinder> make_eye_depth_from_source(std::string_view engine, const EngineOptions& options) {
    return make_of(finders, find_engine(engine), "--method")(options);
}

GlFillChain make_gl_fill_chain(const std::string& list, GlFillShared& shared) {
    GlFillChain chain;
    for (const FillStage* stage : parse_fills(list))
        chain.push_back(make_of(passes, *stage, "--fill")(shared));
    return chain;
}

std::string with_passes_of_gpu(const std::string& list, std::vector<std::string>& notes) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 3> instead = {
        {{"small-wide", "small"}, {"spread", "pushpull"}, {"geometry", ""}}};
    std::string passes_of_gpu;
    for (const std::string_view word : split_at_commas(list)) {
        const auto found = std::ranges::find(instead, word, [](const auto& pair) { return pair.first; });
        const std::string_view taken = found == instead.end() ? word : found->second;
        if (found != instead.end())
            notes.push_back("--fill " + std::string(word) +
                            " is in play only: " + (taken.empty() ? "it is ignored" : std::string(taken) + " is used"));
        if (!taken.empty())
            passes_of_gpu += (passes_of_gpu.empty() ? "" : ",") + std::string(taken);
    }
    return passes_of_gpu.empty() ? "none" : passes_of_gpu;
}

}  // namespace equistream::gl
