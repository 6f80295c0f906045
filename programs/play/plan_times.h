#pragma once
/// What each part of a frame's work takes, and so what a way to play takes that was never played.
#include "plan.h"

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::play {

/// A piece of work that ways to play have in common.
struct Part {
    std::string name;
    double mesh_share = 0;  ///< where its time depends on that, else 0

    auto operator<=>(const Part&) const = default;
};

/// Milliseconds.
using PartTimes = std::map<Part, double>;

double total_ms(const PartTimes& times);

/// The names, said once for whoever times them and for parts_of.
namespace part {
Part frame();  ///< the main picture: decoded, converted
Part track(std::string_view name);
Part depth(const Plan& plan);
Part depth_of(const Plan& plan, std::string_view track);
Part reproject(const Plan& plan);  ///< mirrors and glass included
Part fill(const Plan& plan, std::string_view rung);
Part reliability();
}  // namespace part

/// Whether it is the stream's and the file system's work, which the rest does not slow down or speed up with.
bool is_decoding(const Part& part);

/// All that a frame played so is made of.
std::vector<Part> parts_of(const Plan& plan);

/// Parts as they were timed last.
class KnownTimes {
public:
    void learn(const PartTimes& times);
    /// The same, and all other parts but decoding are scaled as those of their kind (depth, reprojection, each its own)
    /// among the given have changed together, or as all have where none is of it. What hardly took any time before, as
    /// depth while the head rests, cannot tell by its ratio: then none is thought to take more than its kind does now.
    void bring_up_to_date(const PartTimes& times);
    /// Bounds of a way's time: parts that are not known take no time, or any. A mesh of another density is bounded from
    /// both sides by one that is known, as the number of cells goes at most with the inverse of the share: that bounds
    /// the square of their side. A rung that has more left to fill than when it was timed may take longer than either.
    double at_least_ms(const Plan& plan) const;
    double at_most_ms(const Plan& plan) const { return at_most_ms(parts_of(plan)); }
    double at_most_ms(std::span<const Part> parts) const;

private:
    enum class Bound { lower, upper };
    double bound_ms(std::span<const Part> parts, Bound bound) const;
    double bound_ms(const Part& part, Bound bound) const;

    PartTimes times_;
};

}  // namespace equistream::play
