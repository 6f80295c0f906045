#include "stages.h"

#include <equistream/error.h>

#include <algorithm>
#include <array>

namespace equistream {

#define ENGINE(name, old_name, help, needs, finds_depth, on_cpu, on_gpu)                                               \
    std::unique_ptr<Engine> on_cpu(std::string_view, const EngineOptions&);
#define FILL_PASS(name, help, reads, needs_depth, invents, left_out, on_cpu, on_gpu) std::unique_ptr<FillPass> on_cpu();
#include "stage_rows.inc"
#undef ENGINE
#undef FILL_PASS

namespace {

constexpr DepthNeeds no_depth{}, source_depth{.source = true}, both_depths{.source = true, .eye = true};

constexpr unsigned long long track(TrackRole role) {
    return 1ULL << int(role);
}

constexpr bool is_there(std::string_view function) {
    return function != "none";
}

#define ENGINE(name, old_name, help, needs, finds_depth, on_cpu, on_gpu)                                               \
    EngineStage{{name, old_name, help, is_there(#on_gpu)}, needs, finds_depth, on_cpu},
constexpr std::array engines = {
#include "stage_rows.inc"
};
#undef ENGINE

#define DEPTH_SOURCE(name, help, giver, function) DepthStage{{name, "", help, false}, DepthGiver::giver},
constexpr std::array depths = {
#include "stage_rows.inc"
};
#undef DEPTH_SOURCE

#define FILL_PASS(name, help, reads, needs_depth, invents, left_out, on_cpu, on_gpu)                                   \
    FillStage{{name, "", help, is_there(#on_gpu)}, TrackRoles(reads), needs_depth, invents, left_out, on_cpu},
constexpr std::array fills = {
#include "stage_rows.inc"
};
#undef FILL_PASS

template <typename Row>
const Row& find(std::span<const Row> rows, std::string_view name, std::string_view option, const char* before = "",
                std::string_view also = {}) {
    for (const Row& row : rows)
        if (name == row.name || (!name.empty() && name == row.old_name))
            return row;
    std::vector<std::string_view> words = names_of(rows);
    if (!also.empty())
        words.push_back(also);
    throw InputError(
        expected_found(std::string(option), before + in_a_sentence(words, " or "), "'" + std::string(name) + "'"));
}

/// Null: no depth at all.
const DepthStage* depth_stage(std::string_view name) {
    const auto found = std::ranges::find(depth_stages(), name, &DepthStage::name);
    return found == depth_stages().end() ? nullptr : &*found;
}

}  // namespace

std::span<const EngineStage> engine_stages() {
    return engines;
}

std::span<const DepthStage> depth_stages() {
    return depths;
}

std::span<const FillStage> fill_stages() {
    return fills;
}

const EngineStage& find_engine(std::string_view name, std::string_view option, std::string_view also) {
    return find(engine_stages(), name, option, "", also);
}

const DepthStage& find_depth(std::string_view name, std::string_view option) {
    return find(depth_stages(), name, option);
}

const FillStage& find_fill(std::string_view name, std::string_view option) {
    return find(fill_stages(), name, option, "none, or a list of ");
}

std::vector<const FillStage*> parse_fills(std::string_view list, std::string_view option) {
    std::vector<const FillStage*> found;
    if (list == "none")
        return found;
    for (const std::string_view name : split_at_commas(list))
        found.push_back(&find_fill(name, option));
    return found;
}

void require_on_gpu(const Stage& stage, std::string_view option) {
    if (!stage.on_gpu)
        throw InputError(
            expected_found(std::string(option), "a stage of the OpenGL backend", "'" + std::string(stage.name) + "'"));
}

bool is_drawn(std::string_view depth) {
    const DepthStage* stage = depth_stage(depth);
    return stage != nullptr && stage->giver == DepthGiver::opengl;
}

bool is_cast(std::string_view depth) {
    const DepthStage* stage = depth_stage(depth);
    return stage != nullptr && stage->needs_scene();
}

std::string renamed_note(const Stage& stage, std::string_view given, std::string_view option) {
    if (given == stage.name)
        return "";
    return std::string(option) + " " + std::string(given) + " is now called " + std::string(stage.name);
}

std::unique_ptr<Engine> make_engine(std::string_view name, const EngineOptions& options) {
    const EngineStage& stage = find_engine(name);
    return stage.make(stage.name, options);
}

FillChain make_fill_chain(const std::string& list) {
    FillChain chain;
    for (const FillStage* stage : parse_fills(list))
        chain.push_back(stage->make());
    return chain;
}

}  // namespace equistream
