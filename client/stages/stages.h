#pragma once
/// The stages table: a row for each engine, depth source and fill pass.
///
/// Help texts, accepted words, the viewer's and Python's lists and `play --method auto` read it. A new engine, depth
/// source or fill pass is its own files and a row in client/stages/stage_rows.inc. All functions are pure.
#include <client/fill/fill.h>
#include <client/warp/engine.h>
#include <equistream/stream.h>
#include <equistream/text.h>

#include <concepts>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

/// What every row says.
struct Stage {
    std::string_view name;
    std::string_view old_name;  ///< of earlier versions, still accepted; empty: it has always had this name
    std::string_view help;      ///< a few words
    bool on_gpu = false;        ///< the viewer has it
};

struct EngineStage : Stage {
    DepthNeeds needs;          ///< once the eye has left the source's position
    bool finds_depth = false;  ///< the engine makes the eye's depth itself, of the source's or of a proxy
    std::unique_ptr<Engine> (*make)(std::string_view name, const EngineOptions& options) = nullptr;
};

/// Who computes a depth source's distances.
enum class DepthGiver { rays, opengl, frames };

struct DepthStage : Stage {
    DepthGiver giver = DepthGiver::frames;
    bool needs_scene() const { return giver != DepthGiver::frames; }
};

struct FillStage : Stage {
    TrackRoles reads;          ///< tracks without which it fills nothing
    bool needs_depth = false;  ///< of the main picture or the eye; without it the pass fills nothing
    bool invents = false;      ///< its colours are guessed from the picture's own
    int left_out = 0;          ///< which pass goes first where time is short: the lowest
    std::unique_ptr<FillPass> (*make)() = nullptr;
};

/// Each in the order in which help lists them; fill passes in the order in which they are best run.
std::span<const EngineStage> engine_stages();
std::span<const DepthStage> depth_stages();
std::span<const FillStage> fill_stages();

/// The row of this name or old name. Throws InputError that names `option` and the accepted words.
/// `also`: another word that the option takes.
const EngineStage& find_engine(std::string_view name, std::string_view option = "--method", std::string_view also = {});
const DepthStage& find_depth(std::string_view name, std::string_view option = "--depth");
const FillStage& find_fill(std::string_view name, std::string_view option = "--fill");
/// Rows of a comma-separated list, in its order; "none" alone: no row.
std::vector<const FillStage*> parse_fills(std::string_view list, std::string_view option = "--fill");

/// Throws InputError that names `option` where OpenGL does not have it.
void require_on_gpu(const Stage& stage, std::string_view option);

template <std::derived_from<Stage> Row>
std::vector<std::string_view> names_of(std::span<const Row> rows) {
    std::vector<std::string_view> names;
    for (const Row& row : rows)
        names.push_back(row.name);
    return names;
}

/// Whether depth of that name is found in the scene's geometry, by rays or by OpenGL: the stream's own is not needed.
bool is_cast(std::string_view depth);
/// Whether it is by OpenGL: gl or gl-cube.
bool is_drawn(std::string_view depth);

/// For help texts: a line "NAME  what it is" of each, below what is above; with `only_gpu` of rows that the viewer has.
template <std::derived_from<Stage> Row>
std::string described(std::span<const Row> rows, bool only_gpu = false) {
    constexpr std::size_t column = 14;
    std::string text;
    for (const Row& row : rows) {
        if (!row.on_gpu && only_gpu)
            continue;
        std::string name(row.name);
        name.resize(column, ' ');
        text += "\n" + name + std::string(row.help);
    }
    return text;
}

/// What to tell a user who gave an old name: "--method sphere is now called rotation"; empty for a name of today.
std::string renamed_note(const Stage& stage, std::string_view given, std::string_view option);

}  // namespace equistream
