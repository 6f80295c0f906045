#pragma once
/// `--method auto` while playing: frames that take too long are played by a cheaper plan, and by a more accurate one
/// again once there is room.
#include "choice.h"

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace equistream::play {

struct RechooseOptions {
    std::size_t window = 15;     ///< frames whose median counts; a change is followed by that many at least
    double over = 1.1;           ///< of the budget: a median above it is too slow
    double room = 0.8;           ///< of the budget: what a more accurate plan must be estimated to keep to
    std::int64_t patience = 60;  ///< frames since the last change before a step up: 2 s
    std::int64_t longest_patience = 3840;
};

struct Change {
    std::int64_t frame = 0;  ///< index of the first that is played by `to`
    Plan from, to;
    double median_ms = 0;    ///< what frames took by `from`
    double estimate_ms = 0;  ///< what they are thought to take by `to`
    double budget_ms = 0;
    bool is_up = false;  ///< `to` is the more accurate one

    std::string line() const;
};

/// Times are those of the trials, brought up to date by what plays: each frame's parts replace what was known of them,
/// and all other parts but decoding are scaled as those of their kind have changed, since a machine or scene that slows
/// one way to play slows the others. There are no trials while playing, and plans are gone through at most once a
/// window.
///
/// Down: to the most accurate plan below that is thought to keep to the budget, else to the one thought fastest.
/// Up: to the most accurate plan above that is thought to leave room. Whenever a step up is followed by a step down,
/// the next one waits twice as long, so that a plan that is not what it seemed is tried ever more rarely.
class Rechooser {
public:
    /// `plans` from the most accurate down, the chosen one among them.
    Rechooser(std::vector<Plan> plans, const Choice& choice, const RechooseOptions& options = {});

    /// After each frame, with what it took: what is to be played from frame `next` on, where that changes.
    std::optional<Change> played(const PartTimes& times, std::int64_t next);

private:
    void learn();
    std::optional<std::size_t> cheaper(double median_ms) const;
    std::optional<std::size_t> more_accurate() const;
    Change change_to(std::size_t plan, double median_ms, std::int64_t next);

    double at_most_ms(std::size_t plan) const { return known_.at_most_ms(parts_[plan]); }

    std::vector<Plan> plans_;
    std::vector<std::vector<Part>> parts_;  ///< of each plan
    double budget_ms_;
    RechooseOptions options_;
    std::size_t current_;
    KnownTimes known_;
    std::deque<PartTimes> window_;
    std::int64_t frames_since_change_ = 0;
    std::int64_t next_look_down_ = 0, next_look_up_ = 0;  ///< at so many frames since the change
    std::int64_t patience_;
    bool came_up_ = false;  ///< by the last change
};

}  // namespace equistream::play
