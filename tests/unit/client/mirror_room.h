#pragma once
/// A room with a mirror in its floor, in closed form: colours, depth, mask and where images lie.
#include "analytic_scene.h"

namespace equistream::test {

/// A mirror in the floor of a painted room: behind the floor's plane the room is seen again, turned over.
struct MirrorRoom {
    static constexpr double floor_m = -1, mirror_half_width_m = 1.2;

    static glm::dvec3 in_mirror(const glm::dvec3& p) { return {p.x, 2 * floor_m - p.y, p.z}; }
    static double walls(const glm::dvec3& o, const glm::dvec3& d) {
        const double wall = to_plane(o, d, {0, 0, 1}, -4);
        const double side = std::min(to_plane(o, d, {1, 0, 0}, -2.5), to_plane(o, d, {1, 0, 0}, 2.5));
        return std::min({wall, side, to_plane(o, d, {0, 1, 0}, 2), to_plane(o, d, {0, 0, 1}, 3)});
    }
    static double depth(const glm::dvec3& o, const glm::dvec3& d) {
        return std::min(walls(o, d), to_plane(o, d, {0, 1, 0}, floor_m));
    }
    static bool mirrors(const glm::dvec3& p) {
        return std::abs(p.y - floor_m) < 1e-6 && std::abs(p.x) < mirror_half_width_m && p.z < -1 && p.z > -3.5;
    }
    /// From o, to where the image in a mirror lies; to the surface elsewhere.
    static double image_depth(const glm::dvec3& o, const glm::dvec3& d) {
        const double r = depth(o, d);
        if (!mirrors(o + r * d))
            return r;
        return r + walls(o + (r - 1e-9) * d, {d.x, -d.y, d.z});
    }
    static glm::dvec3 paint(const glm::dvec3& p) {
        return 0.5 + 0.5 * (smooth(p, 7) - 0.5) + 0.25 * (smooth(p, 21) - 0.5);
    }
};

struct MirrorView {
    Rendered picture;
    FloatImage specular, image_m;

    MirrorView(const Camera& camera, const Pose& pose)
        : picture(render(
              MirrorRoom::depth, [](const glm::dvec3& p, double) { return MirrorRoom::paint(p); }, camera, pose)),
          specular(width_of(camera), height_of(camera), 1), image_m(width_of(camera), height_of(camera), 1) {
        for (int y = 0; y < height_of(camera); ++y)
            for (int x = 0; x < width_of(camera); ++x) {
                const glm::dvec3 o = pose.position_m, d = pose.orientation * direction_of(camera, x + 0.5, y + 0.5);
                const double r = MirrorRoom::depth(o, d);
                const double image = MirrorRoom::image_depth(o, d);
                const bool mirror = MirrorRoom::mirrors(o + r * d);
                *specular.pixel(x, y) = mirror ? 1.0f : 0.0f;
                *image_m.pixel(x, y) = float(image);
                const glm::dvec3 colour = MirrorRoom::paint(mirror ? MirrorRoom::in_mirror(o + image * d) : o + r * d);
                for (int c = 0; c < 3; ++c)
                    picture.rgb.pixel(x, y)[c] = std::uint8_t(255 * colour[c] + 0.5);
            }
    }
    SourceView source() const {
        SourceView view = picture.source(0.15);
        view.specular = specular.view();
        view.virtual_depth_m = image_m.view();
        return view;
    }
};

}  // namespace equistream::test
