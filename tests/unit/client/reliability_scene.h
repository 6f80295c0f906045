#pragma once
/// A ball before a wall as an eye sees them after reprojection: what the tests of reliability look at.
#include "analytic_scene.h"

#include <client/confidence/reliability.h>
#include <client/fill/fill.h>

namespace equistream::test {

using glm::dvec3;

inline double ball_and_wall(const dvec3& o, const dvec3& d) {
    return std::min(to_sphere(o, d, {0.1, 0, -1.5}, 0.4), to_plane(o, d, {0, 0, 1}, -4));
}

inline dvec3 smooth_colour(const dvec3& p, double) {
    return smooth(p, 1.5);
}

inline const PerspectiveCamera eye_camera{160, 100, pi / 2};
inline const Pose moved{{0.063, 0.02, 0}, {1, 0, 0, 0}};

/// A source, an eye and the picture of it.
struct Played {
    Rendered source;
    FloatImage depth_m;
    EyeView eye;
    EyePicture picture;

    Played(const Distance& distance, const Colour& colour, const Pose& pose, const std::string& method,
           const std::string& fill)
        : source(render(distance, colour, EquirectCamera{640, 320, {}}, Pose{})), depth_m(160, 100, 1) {
        AnalyticDepth(distance).cast(eye_camera, pose, depth_m.view());
        eye = {eye_camera, pose, method == "surface" ? depth_m.view() : ImageView<const float>{}};
        const SourceView view = source.source(0.063);
        const auto engine = make_engine(method);
        engine->set_source(view);
        engine->reproject(eye, picture);
        const FillChain chain = make_fill_chain(fill);
        for (const auto& fill_pass : chain)
            fill_pass->set_frame({.main = &view});
        fill_gaps(chain, eye, picture);
    }
    SourceView view() const { return source.source(0.063); }
    FloatImage risks(const ReliabilityOptions& options = {}) const {
        return reliability_risks(view(), eye, picture, options);
    }
    double mean_where(PixelOrigin origin) const {
        double sum = 0, count = 0;
        for (std::size_t i = 0; i < picture.origin.samples().size(); ++i)
            if (picture.origin.samples()[i] == std::uint8_t(origin)) {
                sum += picture.reliability.samples()[i] / 255.0;
                ++count;
            }
        return count > 0 ? sum / count : -1;
    }
};

}  // namespace equistream::test
