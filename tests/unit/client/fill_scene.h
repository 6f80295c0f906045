#pragma once
/// A red ball before a wall of smooth colour, seen by a main view at the left eye: what the right eye sees of the wall
/// beside the ball is a gap of the `eye-depth` engine, whose truth has a closed form.
#include "analytic_scene.h"

#include <equistream/patches.h>

#include <client/fill/fill.h>
#include <tests/support/patch_ray.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace equistream::test {

inline double ball_and_wall(const glm::dvec3& o, const glm::dvec3& d) {
    return std::min(to_sphere(o, d, {0, 0, -1.2}, 0.3), to_plane(o, d, {0, 0, 1}, -3));
}

inline double wall_alone(const glm::dvec3& o, const glm::dvec3& d) {
    return to_plane(o, d, {0, 0, 1}, -3);
}

inline glm::dvec3 red_and_smooth(const glm::dvec3& p, double) {
    return glm::length(p - glm::dvec3(0, 0, -1.2)) < 0.31 ? glm::dvec3(1, 0, 0) : smooth(p, 1.5);
}

/// The ball and the wall as triangles.
inline void write_model(const std::filesystem::path& file, int steps = 90) {
    std::ofstream obj(file);
    obj << "o ball\n";
    for (int j = 0; j <= steps; ++j)
        for (int i = 0; i <= 2 * steps; ++i) {
            const double longitude = pi * i / steps, latitude = pi * j / steps;
            obj << "v " << 0.3 * std::sin(latitude) * std::cos(longitude) << ' ' << 0.3 * std::cos(latitude) << ' '
                << -1.2 + 0.3 * std::sin(latitude) * std::sin(longitude) << '\n';
        }
    for (int j = 0; j < steps; ++j)
        for (int i = 0; i < 2 * steps; ++i) {
            const int row = 2 * steps + 1, a = 1 + j * row + i;
            obj << "f " << a << ' ' << a + 1 << ' ' << a + row + 1 << ' ' << a + row << '\n';
        }
    obj << "o wall\nv -60 -60 -3\nv 60 -60 -3\nv 60 60 -3\nv -60 60 -3\nf -4 -3 -2 -1\n";
}

inline std::int64_t pixels_of(const Gaps& gaps) {
    std::int64_t count = 0;
    for (const GapSpan& span : gaps.spans())
        count += span.end - span.begin;
    return count;
}

struct FillScene {
    PerspectiveCamera camera{320, 200, pi / 2};
    Pose left{{-0.0315, 0, 0}, {1, 0, 0, 0}};
    Pose right{{0.0315, 0, 0}, {1, 0, 0, 0}};
    PerspectiveCamera main_camera{400, 250, 2 * std::atan(1.25)};  ///< as dense, and wider: all gaps are the ball's
    Rendered main = render(ball_and_wall, red_and_smooth, main_camera, left);
    Rendered truth = render(ball_and_wall, red_and_smooth, camera, right);
    SourceView main_view = main.source(0.063);
    EyeView eye{camera, right, truth.depth_m.view()};
    EyePicture picture, unfilled;

    FillScene() { look_again(); }

    /// After `main` and `truth` have become others.
    void look_again() {
        main_view = main.source(0.063);
        eye.depth_m = truth.depth_m.view();
        const auto engine = make_engine("surface");
        engine->set_source(main_view);
        engine->reproject(eye, picture);
        unfilled = picture;
    }

    /// As an engine leaves it that is given no depth of the eye and finds its own.
    void forget_eye_depth() {
        eye.depth_m = {};
        picture.depth_m = truth.depth_m;
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x)
                if (*picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap))
                    *picture.depth_m.pixel(x, y) = std::nanf("");
        unfilled = picture;
    }

    /// Runs one fill pass; checks that it touched gaps only, marked what it filled and counted it. Returns the share
    /// filled.
    double fill(const std::string& fill_pass, const FillInputs& inputs, PixelOrigin mark) {
        const FillChain chain = make_fill_chain(fill_pass);
        chain[0]->set_frame(inputs);
        Gaps gaps(picture.origin.view());
        const std::int64_t before = pixels_of(gaps);
        const std::int64_t filled = chain[0]->fill(eye, picture, gaps);
        EXPECT_EQ(picture.count(mark), filled);
        EXPECT_EQ(pixels_of(gaps), before - filled);
        EXPECT_EQ(picture.count(PixelOrigin::gap), before - filled);
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                const bool is_new = *picture.origin.pixel(x, y) != *unfilled.origin.pixel(x, y);
                EXPECT_TRUE(!is_new || *unfilled.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap));
                EXPECT_TRUE(is_new || std::equal(picture.rgba.pixel(x, y), picture.rgba.pixel(x, y) + 4,
                                                 unfilled.rgba.pixel(x, y)));
                EXPECT_TRUE(!is_new || picture.rgba.pixel(x, y)[3] == 255);
            }
        return double(filled) / double(before);
    }

    /// Largest difference from the truth, 0 to 255, where a fill pass filled; in the worst of `leave_out` pixels not
    /// counted.
    int worst_filled(PixelOrigin mark, std::size_t leave_out = 0) const {
        std::vector<int> differences;
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                if (*picture.origin.pixel(x, y) != std::uint8_t(mark))
                    continue;
                int worst = 0;
                for (int c = 0; c < 3; ++c)
                    worst = std::max(worst, std::abs(picture.rgba.pixel(x, y)[c] - truth.rgb.pixel(x, y)[c]));
                differences.push_back(worst);
            }
        std::ranges::sort(differences);
        return differences.size() > leave_out ? differences[differences.size() - 1 - leave_out] : 255;
    }
};

// Patches of the ball and the wall of fill_scene.h.

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
