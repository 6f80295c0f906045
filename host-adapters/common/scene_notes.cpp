#include "scene_notes.h"

#include <equistream/text.h>

#include <algorithm>
#include <cmath>

namespace equistream::render_command {
namespace {

/// The largest finite half.
constexpr double brightest_in_frames = 65504;

/// Ray origins are rounded to 0.1 mm here, and rays begin centimetres off their surfaces.
constexpr double farthest_camera_m = 2000;

double farthest_m(const PosePath& path) {
    double farthest = 0;
    for (const PosePath::Key& key : path.keys())
        farthest = std::max(farthest, glm::length(key.pose.position_m));
    return farthest;
}

}  // namespace

std::vector<std::string> scene_notes(const SceneDescription& scene, const PosePath& path) {
    std::vector<std::string> notes;
    if (const double white = scene.exposure * brightest_in_frames; white < 1)
        notes.push_back(formatted("%s: exposure %g shows radiance %g as white, but frames hold at most %g: what is "
                                  "brighter than %.2g of white is cut. Divide all lights by a factor, and multiply "
                                  "exposure by it",
                                  scene.file.string().c_str(), scene.exposure, 1 / scene.exposure, brightest_in_frames,
                                  white));
    if (const double away_m = farthest_m(path); away_m > farthest_camera_m) {
        const auto there = static_cast<float>(away_m);
        const double rounding_m = static_cast<double>(std::nextafter(there, HUGE_VALF) - there);
        notes.push_back(formatted("%s: the camera goes %.0f m from the world's origin: places are rounded to %.2g m "
                                  "there, and light may leak through walls. Move the model and all paths to within "
                                  "%g m of the origin",
                                  scene.file.string().c_str(), away_m, rounding_m, farthest_camera_m));
    }
    return notes;
}

}  // namespace equistream::render_command
