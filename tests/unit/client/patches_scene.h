#pragma once
/// Patches of the ball and the wall of fill_scene.h.
#include "fill_scene.h"

#include <equistream/patches.h>

namespace equistream::test {

/// Every second block of the sphere's middle from one place, all of it from another.
struct Patches {
    PatchAtlas atlas;
    ByteImage rgb;
    FloatImage depth_m;

    Patches() {
        atlas.sphere_width = 1024;
        atlas.sphere_height = 512;
        atlas.offsets_m = {{0.02, 0, 0}, {0.063, 0, 0}};
        atlas.columns = 16;
        for (std::uint8_t offset = 0; offset < 2; ++offset)
            for (std::uint16_t y = 8; y < 24; ++y)
                for (std::uint16_t x = 20; x < 44; ++x)
                    if (offset == 1 || (x + y) % 2 == 0)
                        atlas.slots.push_back({offset, x, y, true});
        while (atlas.slots.size() % 16 != 0)
            atlas.slots.push_back({});
        atlas.rows = int(atlas.slots.size()) / 16;
        EXPECT_FALSE(patch_atlas_problem(atlas));
        rgb = ByteImage(atlas.width(), atlas.height(), 3);
        depth_m = FloatImage(atlas.width(), atlas.height(), 1, std::nanf(""));
    }
    PatchesView view(const Pose& pose) const {
        return {.rgb = rgb.view(), .depth_m = depth_m.view(), .atlas = &atlas, .pose = pose, .box_radius_m = 0.063};
    }
    void render_from(const Pose& sphere_pose) {
        for (int y = 0; y < atlas.height(); ++y)
            for (int x = 0; x < atlas.width(); ++x) {
                if (!atlas.slot_at(x, y).used)
                    continue;
                const PatchRay ray = patch_ray(atlas, x, y, x + 0.5, y + 0.5);
                const glm::dvec3 origin = sphere_pose.position_m + ray.origin_m;
                const double r = ball_and_wall(origin, ray.direction);
                const glm::dvec3 colour = red_and_smooth(std::isinf(r) ? ray.direction : origin + r * ray.direction, r);
                for (int c = 0; c < 3; ++c)
                    rgb.pixel(x, y)[c] = std::uint8_t(255 * colour[c] + 0.5);
                *depth_m.pixel(x, y) = float(r);
            }
    }
};

}  // namespace equistream::test
