// Hidden layers through the C ABI: a ball in a large room, in closed form, and many eyes of the head box asked in turn.
#include "abi_fixture.h"

#include <equistream/bound.h>

#include <algorithm>
#include <cstring>
#include <random>

namespace equistream::testing {
namespace {

constexpr double ball_radius = 0.5, room_radius = 4;
const glm::dvec3 ball_centre(0.3, 0.2, -1.6);

/// The nearest of ball (from either side) and room beyond t_min; 0: neither.
struct Met {
    double distance_m = INFINITY;
    int what = 0;  ///< 1 ball, 2 room
};

Met meet(const glm::dvec3& origin, const glm::dvec3& direction, double t_min) {
    Met nearest;
    const auto sphere = [&](const glm::dvec3& centre, double radius, int what) {
        const glm::dvec3 to = origin - centre;
        const double b = glm::dot(to, direction), d = b * b - glm::dot(to, to) + radius * radius;
        for (const double side : {-1.0, 1.0})
            if (const double t = -b + side * std::sqrt(std::max(d, 0.0)); d > 0 && t > t_min && t < nearest.distance_m)
                nearest = {t, what};
    };
    sphere(ball_centre, ball_radius, 1);
    if (direction.x < 0.3)  // to the right the room is open: sky
        sphere({0, 0, 0}, room_radius, 2);
    return nearest;
}

glm::dvec3 vector(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

es_surface surface_of(const es_ray& ray) {
    es_surface s{};
    s.distance_m = static_cast<float>(meet(vector(ray.origin), vector(ray.direction), ray.t_min).distance_m);
    return s;
}

/// Red: the ball. Blue: the room. Alpha as it should be.
glm::vec4 colour_of(const es_ray& ray) {
    const int what = meet(vector(ray.origin), vector(ray.direction), ray.t_min).what;
    return {what == 1, 0, what == 2, what != 0};
}

class HiddenLayerTest : public AbiTest {
protected:
    void SetUp() override {
        AbiTest::SetUp();
        settings.width = 360;
        settings.height = 180;
        settings.head_radius_m = 0.1;
        settings.aovs = "depth";
        settings.layer = ES_LAYER_HIDDEN;
    }
    Frame rendered(int threads = 1) {
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(0));
        fill(frame, surface_of, colour_of, threads);
        end(frame);
        es_sequence_close(sequence);
        return read_exr(output + "/" + frame_file_name(0));
    }
    glm::dvec3 direction(int x, int y) const {
        return EquirectCamera{settings.width, settings.height, {}}.direction(x + 0.5, y + 0.5);
    }
    double box_radius_m() const { return settings.head_radius_m + settings.ipd_m / 2; }
};

TEST_F(HiddenLayerTest, WhatEyesUncoverIsThereAndWhatNoneDoesIsNot) {
    const Frame frame = rendered();
    const FloatImage &depth = frame.planes.at("depth"), &colour = frame.planes.at("colour");
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::vector<glm::dvec3> eyes;
    while (eyes.size() < 400) {  // where they uncover the most: on the box's surface
        const glm::dvec3 v(normal(random), normal(random), normal(random));
        eyes.push_back(glm::normalize(v));
    }
    int uncovered = 0, found_of_them = 0, found = 0, needless = 0, backs = 0;
    for (int y = 0; y < settings.height; ++y)
        for (int x = 0; x < settings.width; ++x) {
            const glm::dvec3 d = direction(x, y);
            const Met first = meet({0, 0, 0}, d, 0);
            const float z = *depth.pixel(x, y);
            if (first.what != 1) {
                ASSERT_TRUE(std::isnan(z)) << "only the ball hides anything";
                ASSERT_EQ(colour.pixel(x, y)[3], 0);
                continue;
            }
            const auto some_eye_sees = [&](const Met& thing, double radius_m, double off_rad = 1e-9) {
                return std::any_of(eyes.begin(), eyes.end(), [&](const glm::dvec3& at) {
                    const glm::dvec3 eye = radius_m * at;
                    const glm::dvec3 to = std::isinf(thing.distance_m) ? d : thing.distance_m * d - eye;
                    const double distance = std::isinf(thing.distance_m) ? INFINITY : glm::length(to);
                    const double met = meet(eye, glm::normalize(to), 0).distance_m;
                    return met >= distance || displacement_bound_rad(met, distance, box_radius_m()) <= off_rad;
                });
            };
            // The ball's own far side just behind its edge; else what is beyond.
            const Met back = meet({0, 0, 0}, d, first.distance_m + 1e-9);
            const Met beyond = meet({0, 0, 0}, d, 2.5);
            const bool differs =
                displacement_bound_rad(first.distance_m, back.distance_m, box_radius_m()) > error_budget_rad(960);
            const bool sees_back = differs && some_eye_sees(back, box_radius_m());
            const bool sees_beyond = some_eye_sees(beyond, box_radius_m());
            uncovered += sees_back || sees_beyond;
            found_of_them += (sees_back || sees_beyond) && !std::isnan(z);
            if (std::isnan(z))
                continue;
            ++found;
            const bool is_back = std::abs(z - back.distance_m) < 1e-4;
            backs += is_back;
            needless += !some_eye_sees(is_back ? back : beyond, 2.1 * box_radius_m(), error_budget_rad(960) / 4);
            if (sees_back) {
                ASSERT_TRUE(is_back) << "the nearest that is seen, at " << x << "," << y;
            }
            if (!is_back) {
                ASSERT_FLOAT_EQ(z, static_cast<float>(beyond.distance_m));
                ASSERT_EQ(colour.pixel(x, y)[0], 0) << "none of the ball's front";
            }
        }
    EXPECT_GT(backs, 5);
    EXPECT_LT(backs, found / 2);
    EXPECT_GT(uncovered, 100);
    EXPECT_EQ(found_of_them, uncovered);
    EXPECT_EQ(needless, 0);
    EXPECT_LT(found, 3 * uncovered) << "half a pixel more all round, no larger a box";
}

TEST_F(HiddenLayerTest, TheSkyBehindAnEdgeIsInfinitelyFarAndColourGoesOnWhereNothingIs) {
    settings.head_radius_m = 0.3;
    const Frame frame = rendered();
    const FloatImage &depth = frame.planes.at("depth"), &colour = frame.planes.at("colour");
    int sky = 0;
    float least = 1, most = 0;
    for (int y = 0; y < settings.height; ++y)
        for (int x = 0; x < settings.width; ++x) {
            sky += std::isinf(*depth.pixel(x, y));
            if (!std::isnan(*depth.pixel(x, y)))
                continue;
            least = std::min(least, colour.pixel(x, y)[2]);
            most = std::max(most, colour.pixel(x, y)[2]);
            if (x > 0 && std::isnan(*depth.pixel(x - 1, y))) {
                EXPECT_LT(std::abs(colour.pixel(x, y)[2] - colour.pixel(x - 1, y)[2]), 0.8f);
            }
        }
    EXPECT_GT(sky, 100);
    EXPECT_GE(least, 0.0f);
    EXPECT_LE(most, 1.0f);
    EXPECT_GT(most, 0.5f) << "the room's blue goes on";
}

TEST_F(HiddenLayerTest, ThreadsAndTilesChangeNothing) {
    settings.width = 128;
    settings.height = 64;
    const Frame one = rendered();
    std::filesystem::remove_all(output);
    settings.tile_side = 1024;
    const Frame large = rendered(3);
    const auto same = [](const FloatImage& a, const FloatImage& b) {
        return std::memcmp(a.samples().data(), b.samples().data(), a.samples().size_bytes()) == 0;
    };
    EXPECT_TRUE(same(one.planes.at("depth"), large.planes.at("depth")));
    EXPECT_TRUE(same(one.planes.at("colour"), large.planes.at("colour")));
}

TEST_F(HiddenLayerTest, FromASinglePointNothingIsHidden) {
    settings.width = 64;
    settings.height = 32;
    settings.head_radius_m = settings.ipd_m = 0;
    const Frame frame = rendered();
    for (const float z : frame.planes.at("depth").samples())
        ASSERT_TRUE(std::isnan(z));
    for (const float c : frame.planes.at("colour").samples())
        ASSERT_EQ(c, 0);
}

TEST_F(HiddenLayerTest, AFlatViewHasOneToo) {
    settings.camera = ES_PERSPECTIVE;
    settings.width = settings.height = 96;
    const Frame frame = rendered();
    int found = 0;
    for (const float z : frame.planes.at("depth").samples())
        found += !std::isnan(z);
    EXPECT_GT(found, 50);
    EXPECT_LT(found, 96 * 96 / 4);
}

TEST_F(HiddenLayerTest, WholePlanesStayAsTheyAre) {
    const std::size_t rows = 180, pixels = 360 * rows;
    const std::vector<float> colour(4 * pixels, 0.5f), depth(pixels, 3);
    es_sequence* sequence = open();
    const auto put = [](es_frame* frame, const char* name, std::int32_t channels, const std::vector<float>& samples) {
        es_plane plane{};
        plane.struct_size = sizeof plane;
        plane.name = name;
        plane.type = ES_FLOAT32;
        plane.channels = channels;
        plane.data = samples.data();
        plane.row_stride_bytes = samples.size() / rows * sizeof(float);
        es_error error{};
        EXPECT_EQ(es_frame_put_plane(frame, &plane, &error), ES_OK) << error.text;
    };
    const auto expect_all = [](const FloatImage& image, float value) {
        for (const float sample : image.samples())
            ASSERT_EQ(sample, value);
    };
    es_frame* whole = begin(sequence, at(0));
    put(whole, "colour", 4, colour);
    put(whole, "depth", 1, depth);
    end(whole);
    const Frame first = read_exr(output + "/" + frame_file_name(0));
    expect_all(first.planes.at("colour"), 0.5f);
    expect_all(first.planes.at("depth"), 3);

    es_frame* only_colour = begin(sequence, at(1));
    fill(only_colour, surface_of, colour_of);
    put(only_colour, "colour", 4, colour);
    end(only_colour);
    es_sequence_close(sequence);
    const Frame second = read_exr(output + "/" + frame_file_name(1));
    expect_all(second.planes.at("colour"), 0.5f);
    int holes = 0;
    for (const float z : second.planes.at("depth").samples())
        holes += std::isnan(z);
    EXPECT_GT(holes, 0);
    EXPECT_LT(holes, static_cast<int>(pixels));
}

TEST_F(HiddenLayerTest, OtherLayersFramesAreNotAddedTo) {
    es_sequence_close(open());
    settings.layer = ES_LAYER_FIRST;
    EXPECT_NE(refusal().find("expected fingerprint"), std::string::npos) << refusal();
}

TEST_F(HiddenLayerTest, MisuseIsToldWhenTheFrameEnds) {
    es_sequence* sequence = open();
    const auto problem = [&](auto&& misuse) {
        es_frame* frame = begin(sequence, at(0));
        es_tile tile{};
        EXPECT_EQ(es_frame_next_tile(frame, &tile), ES_OK);
        std::vector<es_ray> rays(tile.pixel_count);
        std::vector<float> numbers(4 * tile.pixel_count);
        misuse(frame, tile, rays, numbers);
        es_error error{};
        EXPECT_EQ(es_frame_end(frame, &error), ES_BAD_INPUT);
        return std::string(error.text);
    };
    EXPECT_EQ(problem([](es_frame* f, const es_tile& t, auto& rays, auto&) {
                  EXPECT_EQ(es_tile_colour_rays(f, &t, 0, rays.data()), 0u);
              }),
              "frame 0: es_tile_colour_rays: expected a tile whose probe rays are answered, found tile 0");
    EXPECT_EQ(problem([](es_frame* f, const es_tile& t, auto&, auto& numbers) {
                  es_tile_put_distances(f, &t, numbers.data());
              }),
              "frame 0: es_tile_put_distances: expected answers to es_tile_probe_rays, found none asked for in tile 0");
    es_sequence_close(sequence);
}

}  // namespace
}  // namespace equistream::testing
