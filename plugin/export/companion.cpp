#include <equistream/error.h>
#include <equistream/sequence.h>

#include <cmath>

namespace equistream {

namespace {

/// Import works out the head from each eye's camera.
constexpr double rounding_m = 1e-9, rounding_of_turns = 1e-12;

bool turned_alike(const glm::dquat& a, const glm::dquat& b) {
    return std::abs(glm::dot(a, b)) >= (1 - rounding_of_turns) * glm::length(a) * glm::length(b);
}

/// Null where all is the same.
const char* difference(Companion companion, const FrameInfo& main, const FrameInfo& other) {
    const char* differs = other.scene != main.scene                                 ? "scene"
                          : other.geometry_fingerprint != main.geometry_fingerprint ? "geometry"
                          : other.time_s != main.time_s                             ? "time"
                                                                                    : nullptr;
    if (differs == nullptr && companion >= Companion::head)
        differs = glm::distance(other.head.position_m, main.head.position_m) > rounding_m ? "head position"
                  : !turned_alike(other.head.orientation, main.head.orientation)          ? "head orientation"
                  : other.ipd_m != main.ipd_m                                             ? "distance between the eyes"
                                                                                          : nullptr;
    if (differs == nullptr && companion >= Companion::light)
        differs = other.exposure != main.exposure ? "exposure" : other.seed != main.seed ? "seed" : nullptr;
    if (differs == nullptr && companion >= Companion::eye)
        differs = other.eye != main.eye ? "eye" : nullptr;
    return differs;
}

}  // namespace

Companion companion_of(TrackRole role) {
    return role == TrackRole::hidden || role == TrackRole::patches ? Companion::eye : Companion::light;
}

void require_companion(Companion companion, const std::filesystem::path& main_folder, const FrameInfo& main,
                       const std::filesystem::path& folder, const FrameInfo& other, const std::string& hint) {
    if (const char* differs = difference(companion, main, other))
        throw InputError(expected_found(folder.string() + ", frame " + std::to_string(main.index),
                                        "the " + std::string(differs) + " of " + main_folder.string(),
                                        "another one; render both with one command" + hint));
}

}  // namespace equistream
