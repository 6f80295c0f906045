#pragma once
/// Figures of a run: times by stage, gaps and what filled them, bytes. Written as report.json and as a table.
#include "choice.h"
#include "head_steering.h"
#include "settings.h"

#include <client/pipeline/eye_steps.h>

#include <client/receive/receive.h>
#include <client/timing/viewing.h>

#include <nlohmann/json.hpp>

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace equistream::play {

inline constexpr std::array<const char*, 7> stage_names = {"decode", "convert",     "depth", "reproject",
                                                           "fill",   "reliability", "write"};
enum class Stage { decode, convert, depth, reproject, fill, reliability, write };

/// Milliseconds of one stage of one frame: one sample, or one for each repetition.
using StageTimes = std::array<std::vector<double>, stage_names.size()>;

struct FrameFigures {
    std::int64_t index = 0;
    double time_s = 0;
    bool has_small = false;
    bool outside_head_box = false;  ///< an eye left the ball that the source was rendered for (bound.h)
    bool lacks_depth = false;       ///< its depth is lost, so that eyes only turned
    StageTimes milliseconds;
    double extrapolation_s = 0;                           ///< of what moves, where it was extrapolated
    std::int64_t moved_pixels = 0, uncovered_pixels = 0;  ///< of the source then
    EyeFigures left, right;
};

/// What decides the views, as report.json keeps it.
nlohmann::ordered_json settings_json(const Settings& settings);
/// What can be said before the first view.
nlohmann::ordered_json begun_report_json(const Settings& settings);

struct Report {
    /// Of so many frames figures are kept, about a kilobyte each without --repeat: half a minute at 30 a second. Of so
    /// many refreshes, the latest, json() says what was seen; its sums and percentiles are of all.
    static constexpr std::size_t kept_frames = 1000;

    Settings settings;
    std::string method;            ///< as used, of --method auto at the start
    std::string depth;             ///< so too; "none" where nothing needed it
    std::string gl_driver;         ///< whose OpenGL draws depth; empty where nobody's does
    std::string fill;              ///< so too
    std::optional<Choice> choice;  ///< of --method auto, at the start
    std::vector<Change> changes;   ///< of it, while playing
    std::vector<std::string> notes;
    std::deque<FrameFigures> frames;          ///< by `add`: the latest; with refreshes, those that are not blank
    std::int64_t played = 0;                  ///< frames (or refreshes) in all
    std::int64_t outside_head_box = 0;        ///< of all that were played
    std::int64_t lacking_depth = 0;           ///< the same
    std::optional<Viewing> viewing;           ///< where there are refreshes
    std::optional<SteeringFigures> steering;  ///< where heads were sent
    std::vector<FeedTrack> tracks;
    std::optional<FrameInfo> source;  ///< of the first main picture; nothing where it is foreign video
    std::string truncation;
    double scene_load_ms = 0;
    std::int64_t output_bytes = 0;

    void add(FrameFigures&& frame);
    nlohmann::ordered_json json() const;
    std::string table() const;
};

}  // namespace equistream::play
