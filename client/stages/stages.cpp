#include <equistream_client/stages.h>

#include <fill/geometry_rung.h>
#include <fill/picture_rungs.h>
#include <fill/push_pull_rung.h>
#include <fill/spread_rung.h>
#include <reproject/found_depth_engine.h>
#include <reproject/look_up_engine.h>

#include <equistream/error.h>

#include <algorithm>
#include <array>
#include <utility>

namespace equistream {

namespace {

constexpr DepthNeeds no_depth{}, source_depth{.source = true}, both_depths{.source = true, .eye = true};

constexpr std::array engines = {
    EngineStage{{"rotation", "sphere", "the eye turns and does not move", true}, no_depth, false, make_look_up_engine},
    EngineStage{
        {"proxy-sphere", "lean", "no depth: things lie on a sphere", true}, no_depth, true, make_found_depth_engine},
    EngineStage{{"eye-depth", "surface", "by the eye's own depth, which needs the scene's geometry", true},
                both_depths,
                false,
                make_look_up_engine},
    EngineStage{
        {"mesh", "", "an adaptive mesh, cut at depth edges", true}, source_depth, true, make_found_depth_engine},
    EngineStage{{"splat", "", "forward: samples drawn back to front; without OpenGL the fastest", false},
                source_depth,
                true,
                make_found_depth_engine},
    EngineStage{{"mesh-plain", "", "a mesh never cut, a baseline", true}, source_depth, true, make_found_depth_engine},
};

constexpr std::array depths = {
    DepthStage{{"ray", "", "cast from the scene"}, DepthGiver::rays},
    DepthStage{{"gl", "", "drawn from the scene by OpenGL, of a sphere only what the eyes may look up"},
               DepthGiver::opengl},
    DepthStage{{"gl-cube", "", "the same, of a sphere all: six faces of a cube"}, DepthGiver::opengl},
    DepthStage{{"stream", "", "the stream's own depth track"}, DepthGiver::frames},
    DepthStage{{"exact", "", "a render folder's own, or a stream's that is lossless"}, DepthGiver::frames},
};

constexpr unsigned long long track(TrackRole role) {
    return 1ULL << int(role);
}

template <typename Pass>
std::unique_ptr<FillRung> make() {
    return std::make_unique<Pass>();
}

template <SmallRung::Fills fills>
std::unique_ptr<FillRung> make_small() {
    return std::make_unique<SmallRung>(fills);
}

constexpr std::array fills = {
    FillStage{{"hidden", "", "the source's second layer", true},
              track(TrackRole::hidden) | track(TrackRole::hidden_depth),
              true,
              false,
              true,
              7,
              make<HiddenRung>},
    FillStage{{"patches", "", "blocks that the server predicted the eyes to need", true},
              track(TrackRole::patches) | track(TrackRole::patches_depth),
              true,
              false,
              true,
              6,
              make<PatchesRung>},
    FillStage{{"earlier", "", "main pictures of frames before", true}, 0, true, false, false, 5, make<EarlierRung>},
    FillStage{{"small", "", "the small second-eye view", true},
              track(TrackRole::small),
              false,
              false,
              false,
              2,
              make_small<SmallRung::Fills::all_gaps>},
    FillStage{{"small-wide", "", "the same, in wide gaps alone", false},
              track(TrackRole::small),
              false,
              false,
              false,
              3,
              make_small<SmallRung::Fills::wide_gaps>},
    FillStage{{"geometry", "", "the scene's own colours, lit as around the gap", false},
              0,
              false,
              false,
              false,
              4,
              make<GeometryRung>},
    FillStage{
        {"pushpull", "", "coarser levels of the picture itself", true}, 0, false, true, false, 1, make<PushPullRung>},
    FillStage{{"spread", "", "the nearest filled neighbours", false}, 0, false, true, false, 0, make<SpreadRung>},
};

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

std::string renamed_note(const Stage& stage, std::string_view given, std::string_view option) {
    if (given == stage.name)
        return "";
    return std::string(option) + " " + std::string(given) + " is now called " + std::string(stage.name);
}

std::unique_ptr<Engine> make_engine(std::string_view name, const EngineOptions& options) {
    const EngineStage& stage = find_engine(name);
    return stage.make(stage.name, options);
}

FillLadder make_fill_ladder(const std::string& list) {
    FillLadder ladder;
    for (const FillStage* stage : parse_fills(list))
        ladder.push_back(stage->make());
    return ladder;
}

}  // namespace equistream
