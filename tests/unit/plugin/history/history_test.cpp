#include <plugin/history/history.h>

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <numeric>
#include <random>

namespace {

/// Bytes taken in blocks that are large for the pictures here.
std::atomic<std::size_t> large_bytes = 0;

}  // namespace

// Not inlined: the compiler would take our own pair of malloc and free for a mistake.
[[gnu::noinline]] void* operator new(std::size_t size) {
    if (size >= 4096)
        large_bytes += size;
    if (void* memory = std::malloc(size))
        return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace equistream {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// What a pixel-centre ray meets: a fixed point of the world, or what has no end.
struct Hit {
    double distance_m = 5;
    glm::dvec3 normal{0, 0, 1};
    std::uint32_t object = 1, instance = 1;
    double level = 1;  ///< of radiance, without noise
    bool specular = false;
    double shown_m = 0;  ///< 0: distance_m
};

using Trace = std::function<Hit(const glm::dvec3& origin_m, const glm::dvec3& direction)>;
using Noise = std::function<double(std::mt19937_64&)>;

double gaussian(std::mt19937_64& random) {
    return std::normal_distribution<double>(0, 0.5)(random);
}
/// Rare and bright, as paths that find a lamp by chance.
double fireflies(std::mt19937_64& random) {
    return (std::uniform_real_distribution<double>(0, 1)(random) < 0.02 ? 50.0 : 0.0) - 1;
}
double faint(std::mt19937_64& random) {
    return gaussian(random) / 10;
}
double none(std::mt19937_64&) {
    return 0;
}

/// A sequence of frames of what stands still, as a host would make them.
class World {
public:
    World(const Camera& of, Trace hits, Noise of_samples = gaussian)
        : camera(of), trace(std::move(hits)), noise(std::move(of_samples)) {}

    Frame frame(std::int64_t number, const Pose& pose, const Pose& before) {
        const int width = width_of(camera), height = height_of(camera);
        Frame f;
        f.info.index = number;
        f.info.camera = camera;
        f.info.camera_pose = pose;
        f.info.samples_per_pixel = samples;
        for (const auto& [name, channels] : {std::pair("colour", 4),
                                             {"depth", 1},
                                             {"backward", 2},
                                             {"normal", 3},
                                             {"specular", 1},
                                             {"virtual_depth", 1},
                                             {"virtual_backward", 2},
                                             {"samples", 1},
                                             {"variance", 1}})
            f.planes[name] = FloatImage(width, height, channels);
        f.ids["object_id"] = f.ids["instance_id"] = IdImage(width, height, 1);
        truth = FloatImage(width, height, 1);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                fill(f, x, y, pose, before);
        return f;
    }
    /// The next frame, accumulated.
    Frame next(const Pose& pose) {
        const Pose before = index < 0 ? pose : last;
        Frame f = frame(index + 1, pose, before);
        history.accumulate(f, {index, before});
        last = pose;
        ++index;
        return f;
    }

    /// The picture's mean error, in standard errors of `samples_in_all` a pixel; and its mean square error.
    double bias(const Frame& f, double samples_in_all, double deviation) const {
        double sum = 0;
        const auto level = truth.samples();
        for (std::size_t i = 0; i < level.size(); ++i)
            sum += double(f.planes.at("colour").samples()[4 * i] - level[i]);
        return sum / std::sqrt(double(level.size())) / (deviation / std::sqrt(samples_in_all));
    }
    double square_error(const Frame& f) const {
        double sum = 0;
        const auto level = truth.samples();
        for (std::size_t i = 0; i < level.size(); ++i)
            sum += std::pow(double(f.planes.at("colour").samples()[4 * i] - level[i]), 2);
        return sum / double(level.size());
    }
    double mean(const Frame& f, const char* plane) const {
        double sum = 0;
        for (const float value : f.planes.at(plane).samples())
            sum += double(value);
        return sum / double(f.planes.at(plane).samples().size());
    }

    Camera camera;
    Trace trace;
    Noise noise;
    std::uint32_t samples = 4;
    double light = 1;
    History history{32};
    FloatImage truth;
    std::int64_t index = -1;
    Pose last;
    std::mt19937_64 random{7};

private:
    glm::dvec2 motion(const Pose& there, const glm::dvec3& way, glm::dvec2 here) const {
        glm::dvec2 moved = pixel_of(camera, glm::conjugate(there.orientation) * way) - here;
        if (columns_close(camera))
            moved.x = shortest_column_difference(moved.x, width_of(camera), LongitudeLatitudeRange{});
        return moved;
    }
    void fill(Frame& f, int x, int y, const Pose& pose, const Pose& before) {
        const glm::dvec2 here(x + 0.5, y + 0.5);
        const glm::dvec3 way = pose.orientation * direction_of(camera, here.x, here.y);
        const Hit hit = trace(pose.position_m, way);
        const double shown_m = hit.shown_m > 0 ? hit.shown_m : hit.distance_m;
        const auto moved = [&](double distance_m) {
            return motion(
                before, std::isfinite(distance_m) ? pose.position_m + distance_m * way - before.position_m : way, here);
        };
        const glm::dvec2 backward = moved(hit.distance_m), shown_backward = moved(shown_m);
        *f.planes["depth"].pixel(x, y) = float(hit.distance_m);
        *f.planes["virtual_depth"].pixel(x, y) = float(shown_m);
        *f.planes["specular"].pixel(x, y) = hit.specular;
        for (int c = 0; c < 2; ++c) {
            f.planes["backward"].pixel(x, y)[c] = float(backward[c]);
            f.planes["virtual_backward"].pixel(x, y)[c] = float(shown_backward[c]);
        }
        for (int c = 0; c < 3; ++c)
            f.planes["normal"].pixel(x, y)[c] = float(hit.normal[c]);
        *f.ids["object_id"].pixel(x, y) = hit.object;
        *f.ids["instance_id"].pixel(x, y) = hit.instance;
        double sum = 0, squares = 0;
        for (std::uint32_t i = 0; i < samples; ++i) {
            const double level = light * hit.level * (1 + noise(random));
            sum += level;
            squares += level * level;
        }
        const double mean = sum / samples;
        *truth.pixel(x, y) = float(light * hit.level);
        std::fill_n(f.planes["colour"].pixel(x, y), 3, float(mean));
        f.planes["colour"].pixel(x, y)[3] = 1;
        *f.planes["samples"].pixel(x, y) = float(samples);
        if (samples > 1)
            *f.planes["variance"].pixel(x, y) =
                float(std::max(0.0, squares - samples * mean * mean) / samples / (samples - 1));
    }
};

const PerspectiveCamera view{64, 48, pi / 2};
const EquirectCamera sphere{64, 32, {}};

/// A wall with a smooth pattern, five metres ahead of the origin.
Hit wall(const glm::dvec3& origin_m, const glm::dvec3& direction) {
    Hit hit;
    hit.distance_m = (-5 - origin_m.z) / direction.z;
    const glm::dvec3 point_m = origin_m + hit.distance_m * direction;
    hit.level = 1 + 0.3 * std::sin(3 * point_m.x) * std::cos(2 * point_m.y);
    return hit;
}
/// The inside of a ball around the origin, likewise.
Hit ball(const glm::dvec3& origin_m, const glm::dvec3& direction) {
    const double b = glm::dot(origin_m, direction);
    Hit hit;
    hit.distance_m = -b + std::sqrt(b * b - glm::dot(origin_m, origin_m) + 25);
    hit.normal = -(origin_m + hit.distance_m * direction) / 5.0;
    hit.level = 1 + 0.2 * hit.normal.x + 0.3 * hit.normal.y * hit.normal.z;
    return hit;
}
Hit sky(const glm::dvec3&, const glm::dvec3& direction) {
    Hit hit;
    hit.distance_m = double(infinity);
    hit.normal = {0, 0, 0};
    hit.object = hit.instance = 0;
    hit.level = 1 + 0.4 * direction.x + 0.3 * direction.y * direction.z;
    return hit;
}

Pose at(double x, double y = 0, double z = 0) {
    return {{x, y, z}, {1, 0, 0, 0}};
}

TEST(History, ALongWalkPastAWallLosesItsNoiseAndNotItsPattern) {
    World world(view, wall);
    Frame f;
    for (int i = 0; i < 16; ++i)
        f = world.next(at(0.07 * i, 0.02 * i, -0.03 * i));
    EXPECT_LT(world.square_error(f), 0.25 * 1.1 / 4 / std::pow(10, 0.9));
    EXPECT_LT(std::abs(world.bias(f, 64, 0.5)), 3);
    EXPECT_GT(world.mean(f, "samples"), 50);
    EXPECT_NEAR(world.mean(f, "variance") / (0.25 * 1.05 / 64), 1, 0.4);

    World clean(view, wall, none);
    for (int i = 0; i < 60; ++i)
        f = clean.next(at(0.07 * i, 0.02 * i, -0.01 * i));
    EXPECT_LT(std::sqrt(clean.square_error(f)), 0.01);  // of a pattern of 0.15
}

/// Detail of a few pixels, which every look-up between pixels loses some of.
Hit stripes(const glm::dvec3& origin_m, const glm::dvec3& direction) {
    Hit hit = wall(origin_m, direction);
    hit.level = 1 + 0.5 * std::sin(14 * (origin_m + hit.distance_m * direction).x);
    return hit;
}

TEST(History, DetailIsNotLostToFramesWithLittleNoise) {
    double error = 0;
    World world(view, stripes, faint);
    for (int i = 0; i < 16; ++i)
        error = world.square_error(world.next(at(0.07 * i, 0.02 * i)));
    const double of_one_frame = 0.0025 * 1.125 / 4;
    EXPECT_LT(error, 3 * of_one_frame);
    World noisy(view, stripes, gaussian);
    for (int i = 0; i < 16; ++i)
        error = noisy.square_error(noisy.next(at(0.07 * i, 0.02 * i)));
    EXPECT_LT(error, 0.8 * 100 * of_one_frame);
}

TEST(History, AStillHeadsMeanIsThatOfAllSamples) {
    World world(sphere, ball);
    std::vector<double> sums(64 * 32);
    Frame f;
    for (int i = 0; i < 100; ++i) {
        Frame alone = world.frame(i, at(0.3), at(0.3));
        for (std::size_t pixel = 0; pixel < sums.size(); ++pixel)
            sums[pixel] += double(alone.planes["colour"].samples()[4 * pixel]);
        world.history.accumulate(alone, {i - 1, at(0.3)});
        f = std::move(alone);
    }
    for (std::size_t pixel = 0; pixel < sums.size(); ++pixel) {
        ASSERT_NEAR(double(f.planes["colour"].samples()[4 * pixel]), sums[pixel] / 100, 1e-5) << pixel;
        ASSERT_NEAR(double(f.planes["samples"].samples()[pixel]), 400, 0.1);
    }
    EXPECT_NEAR(world.mean(f, "variance") / (0.25 / 400), 1, 0.2);

    World after_a_walk(sphere, ball);
    for (int i = 0; i < 240; ++i)
        f = after_a_walk.next(at(0.05 * std::min(i, 40)));
    EXPECT_GT(after_a_walk.mean(f, "samples"), 900);
}

/// A wall behind a still head slides along by 1/300 of a pixel a frame.
TEST(History, WhatMovesTooLittleToBeLookedUpLagsAQuarterPixelAtMost) {
    const auto lag_px = [](double per_frame_px) {
        World world(view, wall);
        Frame f;
        for (int i = 0; i < 600; ++i) {
            const double slid_m = i * per_frame_px * 5 / 32;
            world.trace = [slid_m](const glm::dvec3& origin_m, const glm::dvec3& direction) {
                Hit hit = wall(origin_m, direction);
                hit.level = wall(origin_m - glm::dvec3(slid_m, 0, 0), direction).level;
                return hit;
            };
            f = world.frame(i, at(0), at(0));
            for (float& motion : f.planes["backward"].samples())
                motion = 0;
            for (std::size_t pixel = 0; pixel < 64 * 48; ++pixel)
                f.planes["backward"].samples()[2 * pixel] = -float(per_frame_px);
            world.history.accumulate(f, {i - 1, at(0)});
        }
        // The shift that explains the difference to the truth best, by least squares.
        double along = 0, gradients = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 1; x < 63; ++x) {
                const double gradient = 0.5 * double(*world.truth.pixel(x + 1, y) - *world.truth.pixel(x - 1, y));
                along += gradient * double(f.planes["colour"].pixel(x, y)[0] - *world.truth.pixel(x, y));
                gradients += gradient * gradient;
            }
        return along / gradients;
    };
    EXPECT_NEAR(lag_px(1.0 / 300), 0.25, 0.05);
    EXPECT_NEAR(lag_px(0), 0, 0.02);
}

/// The next frame with what a denoiser would make of it: the truth times `scale`, and noise in blocks of four by four.
Frame next_denoised(World& world, const Pose& pose, float scale, float block_noise) {
    const Pose before = world.index < 0 ? pose : world.last;
    Frame f = world.frame(world.index + 1, pose, before);
    const int width = world.truth.width(), height = world.truth.height();
    std::normal_distribution<float> noise;
    std::mt19937_64 random(100 + std::uint64_t(world.index + 1));
    std::vector<float> blocks(static_cast<std::size_t>(width * height));
    std::ranges::generate(blocks, [&] { return block_noise * noise(random); });
    f.planes["raw"] = FloatImage(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::copy_n(f.planes["colour"].pixel(x, y), 3, f.planes["raw"].pixel(x, y));
            const float off = blocks[static_cast<std::size_t>(y / 4 * width + x / 4)];
            std::fill_n(f.planes["colour"].pixel(x, y), 3, scale * *world.truth.pixel(x, y) + off);
        }
    world.history.accumulate(f, {world.index, before});
    world.last = pose;
    ++world.index;
    return f;
}

TEST(History, DenoisedFramesAreCarriedOnByTheSameWeights) {
    World world(view, wall), plain(view, wall);
    Frame f, expected;
    for (int i = 0; i < 16; ++i) {
        const Pose pose = at(0.07 * i, 0.02 * i, -0.03 * i);
        f = next_denoised(world, pose, 1, 0.1f);
        expected = plain.next(pose);
    }
    EXPECT_LT(world.square_error(f), 0.01 / 10);
    for (std::size_t i = 0; i < expected.planes["samples"].samples().size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_EQ(f.planes["raw"].samples()[3 * i + c], expected.planes["colour"].samples()[4 * i + c]) << i;
}

TEST(History, AStillHeadsDenoisedFramesLoseTheirBiasAndGainNoNoise) {
    World biased(sphere, ball), exact(sphere, ball);
    Frame f, g;
    for (int i = 0; i < 200; ++i) {
        f = next_denoised(biased, at(0), 0.8f, 0);
        g = next_denoised(exact, at(0), 1, 0);
        if (i == 0) {
            EXPECT_NEAR(biased.square_error(f), 0.04 * 1.05, 0.01);
        }
    }
    const double noise = 0.25 * 1.05 / 800;
    EXPECT_LT(biased.square_error(f), 2 * noise);  // of a bias of 0.04
    EXPECT_LT(exact.square_error(g), 0.05 * noise);
}

TEST(History, NoiseAloneIsNeverTakenForLight) {
    for (const auto& [noise, deviation] : {std::pair(Noise(gaussian), 0.5), {Noise(fireflies), 7.0}}) {
        World world(sphere, ball, noise);
        Frame f;
        for (int i = 0; i < 1000; ++i)
            f = world.next(at(0));
        EXPECT_LT(std::abs(world.bias(f, 4000, deviation)), 3);
        EXPECT_GT(world.mean(f, "samples"), 3900);
    }
}

TEST(History, AChangeOfLightIsForgottenWithinHalfASecond) {
    for (const double step_m : {0.0, 0.02})
        for (const double light : {0.9, 1.1, 0.2, 5.0}) {
            World world(EquirectCamera{192, 96, {}}, ball);
            for (int i = 0; i < 40; ++i)
                world.next(at(step_m * i));
            world.light = light;
            Frame f;
            for (int i = 40; i < 55; ++i)
                f = world.next(at(step_m * i));
            double off = 0, level = 0;
            for (const float value : f.planes["colour"].samples())
                off += double(value);
            off = (off - double(192 * 96)) / 3;  // without alpha
            for (const float value : world.truth.samples())
                level += double(value);
            EXPECT_LT(std::abs(off - level), 0.05 * std::abs(level / light - level)) << light << " " << step_m;
        }
}

/// Samples a pixel in the middle of a picture that had five frames, when the sixth changes.
double samples_after(Trace before, Trace after, const Pose& pose = at(0)) {
    World world(view, before, none);
    for (int i = 0; i < 5; ++i)
        world.next(at(0));
    world.trace = after;
    const Frame f = world.next(pose);
    return double(*f.planes.at("samples").pixel(32, 24));
}

TEST(History, AnotherThingBeginsAnew) {
    const auto other = [](const std::function<void(Hit&)>& change) {
        return [change](const glm::dvec3& origin_m, const glm::dvec3& direction) {
            Hit hit = wall(origin_m, direction);
            change(hit);
            return hit;
        };
    };
    EXPECT_NEAR(samples_after(wall, wall), 24, 0.01);
    EXPECT_NEAR(samples_after(wall, wall, at(0.1)), 24, 0.01);
    EXPECT_EQ(samples_after(wall, other([](Hit& hit) { hit.object = 2; })), 4);
    EXPECT_EQ(samples_after(wall, other([](Hit& hit) { hit.instance = 2; })), 4);
    EXPECT_EQ(samples_after(wall, other([](Hit& hit) { hit.distance_m *= 1.05; })), 4);
    EXPECT_EQ(samples_after(wall, other([](Hit& hit) { hit.normal = {std::sin(0.6), 0, std::cos(0.6)}; })), 4);
    EXPECT_EQ(samples_after(wall, other([](Hit& hit) { hit.specular = true; })), 4);
    EXPECT_EQ(samples_after(wall, sky), 4);
    const auto mirror = [&](double shown_m) {
        return other([shown_m](Hit& hit) {
            hit.specular = true;
            hit.shown_m = shown_m;
        });
    };
    EXPECT_NEAR(samples_after(mirror(9), mirror(9)), 24, 0.01);
    EXPECT_EQ(samples_after(mirror(9), mirror(10)), 4);
}

TEST(History, WhatComesOutBehindAnEdgeBeginsAnew) {
    const Trace post = [](const glm::dvec3& origin_m, const glm::dvec3& direction) {
        const double distance_m = (-2 - origin_m.z) / direction.z;
        if (std::abs(origin_m.x + distance_m * direction.x) > 0.3)
            return wall(origin_m, direction);
        Hit hit;
        hit.distance_m = distance_m;
        hit.object = hit.instance = 2;
        return hit;
    };
    World world(view, post, faint);
    Frame f;
    for (int i = 0; i < 6; ++i)
        f = world.next(at(0.25 * i));
    int fresh_of_wall = 0, fresh_of_post = 0;
    for (int x = 4; x < 60; ++x)
        (*f.ids["object_id"].pixel(x, 24) == 2 ? fresh_of_post : fresh_of_wall) +=
            *f.planes["samples"].pixel(x, 24) == 4;
    EXPECT_EQ(fresh_of_post, 0);
    EXPECT_GE(fresh_of_wall, 1);
    EXPECT_LE(fresh_of_wall, 3);
    EXPECT_LT(std::sqrt(world.square_error(f)), 0.03);
}

TEST(History, WhatAMirrorShowsIsCarriedByItsOwnMotion) {
    // A mirror two metres ahead shows a pattern seven metres ahead.
    World world(
        view,
        [](const glm::dvec3& origin_m, const glm::dvec3& direction) {
            Hit hit;
            hit.distance_m = (-2 - origin_m.z) / direction.z;
            hit.shown_m = (-7 - origin_m.z) / direction.z;
            hit.specular = true;
            hit.level = 1 + 0.5 * std::sin(2 * (origin_m.x + hit.shown_m * direction.x));
            return hit;
        },
        faint);
    Frame f;
    for (int i = 0; i < 40; ++i)
        f = world.next(at(0.03 * i));
    EXPECT_LT(std::sqrt(world.square_error(f)), 0.03);  // of 0.35
    EXPECT_GT(world.mean(f, "samples"), 60);
}

TEST(History, NoDarkRingGrowsAroundTheSun) {
    // It fills one pixel, and the head turns by parts of one.
    World world(
        view,
        [](const glm::dvec3&, const glm::dvec3& direction) {
            Hit hit;
            hit.distance_m = infinity;
            hit.level = direction.z < -std::cos(0.02) ? 1e4 : 1;
            return hit;
        },
        faint);
    Frame f;
    for (int i = 0; i < 20; ++i)
        f = world.next({{0, 0, 0}, glm::angleAxis(0.007 * i, glm::normalize(glm::dvec3(0.4, 1, 0)))});
    EXPECT_GT(*std::ranges::max_element(world.truth.samples()), 1000);
    for (int y = 0; y < f.planes["colour"].height(); ++y)
        for (int x = 0; x < f.planes["colour"].width(); ++x)
            ASSERT_GE(*f.planes["colour"].pixel(x, y), 0.8) << x << ", " << y;
}

TEST(History, TheSeamAndThePolesAreNoEdges) {
    // A head that turns in every way, on a sphere that turns along: everything crosses both.
    World world(sphere, sky, none);
    Frame f;
    for (int i = 0; i < 40; ++i)
        f = world.next({{0, 0, 0}, glm::angleAxis(0.05 * i, glm::normalize(glm::dvec3(1, 0.3, 0.2)))});
    EXPECT_LT(std::sqrt(world.square_error(f)), 0.006);
    EXPECT_GT(double(*std::ranges::min_element(f.planes["samples"].samples())), 100);

    // Half a turn apart, from the same samples: the same picture, half its width apart.
    const glm::dquat half_turn = glm::angleAxis(pi, glm::dvec3(0, 1, 0));
    World one(sphere, ball), other(sphere, [&](const glm::dvec3&origin_m, const glm::dvec3&direction) {
        Hit hit = ball(half_turn * origin_m, half_turn * direction);
        hit.normal = half_turn * hit.normal;
        return hit;
    });
    Frame second;
    for (int i = 0; i < 12; ++i) {
        f = one.frame(i, at(0.1 * i, 0.05 * i), at(0.1 * std::max(0, i - 1), 0.05 * std::max(0, i - 1)));
        second = other.frame(i, at(-0.1 * i, 0.05 * i), at(-0.1 * std::max(0, i - 1), 0.05 * std::max(0, i - 1)));
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 64; ++x)
                for (const char* name : {"colour", "variance"})
                    std::copy_n(f.planes[name].pixel((x + 32) % 64, y), f.planes[name].channels(),
                                second.planes[name].pixel(x, y));
        one.history.accumulate(f, {i - 1, at(0.1 * std::max(0, i - 1), 0.05 * std::max(0, i - 1))});
        other.history.accumulate(second, {i - 1, at(-0.1 * std::max(0, i - 1), 0.05 * std::max(0, i - 1))});
    }
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x)
            ASSERT_NEAR(double(f.planes["colour"].pixel((x + 32) % 64, y)[0]),
                        double(second.planes["colour"].pixel(x, y)[0]), 2e-3)
                << x << " " << y;
}

TEST(History, AFrameThatIsTakenBackIsGivenAgain) {
    World world(sphere, ball), other(sphere, ball);
    Frame expected, found;
    for (int i = 0; i < 6; ++i) {
        const Pose here = at(0.02 * i), before = at(0.02 * std::max(0, i - 1));
        expected = world.frame(i, here, before);
        found = expected;
        world.history.accumulate(expected, {i - 1, before});
        Frame lost = found;
        other.history.accumulate(found, {i - 1, before});
        if (i == 0 || i == 4) {
            other.history.take_back();
            found = lost;
            other.history.accumulate(found, {i - 1, before});
        }
        for (const char* name : {"colour", "samples", "variance"})
            EXPECT_TRUE(std::ranges::equal(expected.planes[name].samples(), found.planes[name].samples())) << i << name;
    }
    EXPECT_GT(world.mean(found, "samples"), 20);
}

TEST(History, AFrameThatDoesNotFollowBeginsAnew) {
    const auto samples = [](const std::function<void(World&, Frame&)>& give) {
        World world(sphere, ball);
        for (int i = 0; i < 3; ++i)
            world.next(at(0));
        Frame f = world.frame(3, at(0), at(0));
        give(world, f);
        return world.mean(f, "samples");
    };
    EXPECT_NEAR(samples([](World& world, Frame& f) { world.history.accumulate(f, {2, at(0)}); }), 16, 0.01);
    EXPECT_EQ(samples([](World& world, Frame& f) { world.history.accumulate(f, {1, at(0)}); }), 4);
    EXPECT_EQ(samples([](World& world, Frame& f) { world.history.accumulate(f, {2, at(0.1)}); }), 4);
    // A window that has moved: its pixels are other ones.
    EXPECT_EQ(samples([](World& world, Frame& f) {
                  LongitudeLatitudeRange& range = std::get<EquirectCamera>(f.info.camera).range;
                  range.longitude_min += 0.1;
                  range.longitude_max += 0.1;
                  world.history.accumulate(f, {2, at(0)});
              }),
              4);
}

TEST(History, SamplesThatAreNotFinite) {
    World world(sphere, ball);
    Frame f = world.frame(0, at(0), at(0));
    *f.planes["samples"].pixel(3, 3) = 0;
    f.planes["colour"].pixel(5, 5)[1] = std::nanf("");
    f.planes["colour"].pixel(6, 6)[2] = infinity;
    world.history.accumulate(f, {-1, at(0)});
    for (const auto& [x, y] : {std::pair(3, 3), {5, 5}, {6, 6}}) {
        EXPECT_EQ(*f.planes["samples"].pixel(x, y), 0);
        EXPECT_EQ(f.planes["colour"].pixel(x, y)[0], 0);
    }
    for (int i = 1; i < 4; ++i) {
        f = world.frame(i, at(0.01 * i), at(0.01 * (i - 1)));
        f.planes["colour"].pixel(9, 9)[0] = i == 3 ? infinity : 1e30f;
        *f.planes["variance"].pixel(9, 9) = infinity;
        world.history.accumulate(f, {i - 1, at(0.01 * (i - 1))});
    }
    EXPECT_GT(*f.planes["samples"].pixel(5, 5), 10);
    for (const char* name : {"colour", "samples", "variance"})
        for (const float value : f.planes[name].samples())
            ASSERT_TRUE(std::isfinite(value)) << name;
}

TEST(History, WholePlanesSayNoVarianceAndLearnIt) {
    World world(sphere, ball);
    Frame f;
    for (int i = 0; i < 60; ++i) {
        f = world.frame(i, at(0), at(0));
        f.planes.erase("samples");
        f.planes.erase("variance");
        world.history.accumulate(f, {i - 1, at(0)});
    }
    EXPECT_NEAR(world.mean(f, "samples"), 240, 0.1);
    EXPECT_NEAR(world.mean(f, "variance") / (0.25 / 240), 1, 0.25);
}

TEST(History, OnePixel) {
    World world(EquirectCamera{1, 1, {}}, ball);
    Frame f;
    for (int i = 0; i < 5; ++i)
        f = world.next(at(0.01 * i));
    EXPECT_TRUE(std::isfinite(f.planes["colour"].samples()[0]));
    EXPECT_GE(f.planes["samples"].samples()[0], 4);
}

TEST(History, TakesNoMemoryAFrameOnceItHasIt) {
    World world(EquirectCamera{256, 128, {}}, ball, none);
    for (int i = 0; i < 5; ++i) {
        Frame f = world.frame(i, at(0.02 * i), at(0.02 * std::max(0, i - 1)));
        const std::size_t before = large_bytes;
        world.history.accumulate(f, {i - 1, at(0.02 * std::max(0, i - 1))});
        EXPECT_EQ(i >= 2 ? large_bytes - before : 0, 0u) << i;
    }
}

TEST(History, SamplesGoWhereTheyAreFew) {
    World world(EquirectCamera{128, 64, {}}, ball);
    EXPECT_TRUE(world.history.samples_by_tile(world.frame(0, at(0), at(0)).info, 32).empty());
    for (int i = 0; i < 8; ++i)
        world.next(at(0));
    Frame f = world.frame(8, at(0), at(0));
    for (int y = 0; y < 32; ++y)
        for (int x = 32; x < 64; ++x)
            *f.ids["object_id"].pixel(x, y) = 2;  // has just come
    world.history.accumulate(f, {7, at(0)});
    const std::vector<std::uint32_t> counts = world.history.samples_by_tile(f.info, 32);
    ASSERT_EQ(counts.size(), 8u);
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0u), 32u);
    EXPECT_GE(counts[1], 8u);
    EXPECT_GE(*std::ranges::min_element(counts), 2u);
}

}  // namespace
}  // namespace equistream
