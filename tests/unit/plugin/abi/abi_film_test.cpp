// Rays and film through the C ABI: where rays go, what their samples become, and that threads change nothing.
#include "abi_fixture.h"

#include <fstream>
#include <set>

namespace equistream::testing {
namespace {

class AbiFilm : public AbiTest {
protected:
    /// What the frame's attribute equistream:leftOutSamples says; empty where it has none.
    std::string left_out_noted(std::int64_t index) const {
        std::ifstream file(output + "/" + frame_file_name(index), std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(file), {}};
        const std::string head = std::string("equistream:leftOutSamples") + '\0' + "string" + '\0';
        const std::size_t found = bytes.find(head);
        if (found == std::string::npos)
            return "";
        const std::size_t length_at = found + head.size();  // four bytes, little endian; less than 256 here
        return bytes.substr(length_at + 4, static_cast<unsigned char>(bytes[length_at]));
    }

    /// All rays of a frame, by pixel: geometry (sample < 0) or one colour pass.
    std::vector<es_ray> rays(es_sequence* sequence, const es_frame_settings& when, int sample) const {
        es_frame* frame = begin(sequence, when);
        std::vector<es_ray> all(static_cast<std::size_t>(settings.width) * settings.height);
        std::vector<es_ray> some;
        es_tile tile{};
        while (es_frame_next_tile(frame, &tile) == ES_OK) {
            some.resize(tile.pixel_count);
            if (sample < 0)
                es_tile_geometry_rays(frame, &tile, some.data());
            else
                es_tile_colour_rays(frame, &tile, static_cast<std::uint32_t>(sample), some.data());
            for (std::uint32_t i = 0; i < tile.pixel_count; ++i) {
                EXPECT_EQ(some[i].pixel, i);
                const auto x = static_cast<std::uint32_t>(tile.x) + i % tile.width;
                const auto y = static_cast<std::uint32_t>(tile.y) + i / tile.width;
                all[y * settings.width + x] = some[i];
            }
        }
        es_frame_discard(frame);
        return all;
    }
};

const Pose turned{{1, 2, 3}, glm::normalize(glm::dquat(0.8, 0.1, 0.5, -0.2))};

/// Black frames whose guides are those of pass and pixel; `passes` of them.
es_frame* guided_frame(es_frame* frame, std::uint32_t passes) {
    es_tile tile{};
    std::vector<es_ray> rays;
    while (es_frame_next_tile(frame, &tile) == ES_OK) {
        rays.resize(tile.pixel_count);
        const std::vector<float> rgba(tile.pixel_count * 4);
        for (std::uint32_t pass = 0; pass < tile.sample_count; ++pass) {
            es_tile_colour_rays(frame, &tile, pass, rays.data());
            es_tile_put_radiance(frame, &tile, rgba.data());
            std::vector<float> guides(tile.pixel_count * 6);
            for (std::uint32_t i = 0; i < tile.pixel_count; ++i) {
                guides[6 * i] = static_cast<float>(pass);
                guides[6 * i + 4] = static_cast<float>(tile.x) + static_cast<float>(i % tile.width);
                guides[6 * i + 5] = std::numeric_limits<float>::quiet_NaN();
            }
            if (pass < passes)
                es_tile_put_guides(frame, &tile, guides.data());
        }
    }
    return frame;
}

TEST_F(AbiFilm, guides_are_means_of_all_passes) {
    settings.aovs = "guides";
    es_sequence* sequence = open();
    end(guided_frame(begin(sequence, at(0)), 4));
    const Frame frame = read(0);
    EXPECT_EQ(frame.planes.at("guide_albedo").pixel(5, 3)[0], 1.5f);
    EXPECT_EQ(frame.planes.at("guide_normal").pixel(70, 35)[1], 70);
    EXPECT_EQ(frame.planes.at("guide_normal").pixel(70, 35)[2], 0);
    es_error error{};
    EXPECT_EQ(es_frame_end(guided_frame(begin(sequence, at(1)), 3), &error), ES_BAD_INPUT);
    EXPECT_NE(std::string(error.text).find("plane guide_albedo unfinished in 6 of 6 tiles"), std::string::npos)
        << error.text;
    es_sequence_close(sequence);
    settings.aovs = "none";
    settings.overwrite = 1;
    sequence = open();
    end(guided_frame(begin(sequence, at(0)), 4));  // taken by nobody, and no misuse
    EXPECT_FALSE(read(0).planes.contains("guide_albedo"));
    es_sequence_close(sequence);
}

TEST_F(AbiFilm, every_pixel_is_in_one_tile) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    std::vector<int> seen(static_cast<std::size_t>(settings.width) * settings.height);
    es_tile tile{};
    while (es_frame_next_tile(frame, &tile) == ES_OK)
        for (int y = tile.y; y < tile.y + tile.height; ++y)
            for (int x = tile.x; x < tile.x + tile.width; ++x)
                ++seen[static_cast<std::size_t>(y) * settings.width + x];
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
    es_frame_discard(frame);
    es_sequence_close(sequence);
}

TEST_F(AbiFilm, geometry_rays_pass_through_pixel_centres) {
    for (const es_camera_kind kind : {ES_EQUIRECT, ES_PERSPECTIVE})
        for (const es_axis_lock lock : {ES_LOCK_WORLD, ES_LOCK_PATH}) {
            settings.camera = kind;
            settings.lock = lock;
            settings.eye = ES_EYE_RIGHT;
            settings.overwrite = 1;
            es_sequence* sequence = open();
            const auto all = rays(sequence, at(0, turned, turned, turned), -1);
            const bool turns = kind == ES_PERSPECTIVE || lock == ES_LOCK_PATH;
            const glm::dquat orientation = turns ? turned.orientation : glm::dquat(1, 0, 0, 0);
            const glm::dvec3 eye = turned.position_m + turned.orientation * glm::dvec3(0.0315, 0, 0);
            Camera camera = EquirectCamera{72, 36, {}};
            if (kind == ES_PERSPECTIVE)
                camera = PerspectiveCamera{72, 36, 1.5};
            for (int i = 0; i < 72 * 36; ++i) {
                const glm::dvec3 d = orientation * direction_of(camera, i % 72 + 0.5, i / 72 + 0.5);
                const es_ray& ray = all[static_cast<std::size_t>(i)];
                for (int c = 0; c < 3; ++c) {
                    ASSERT_NEAR(ray.direction[c], d[c], 2e-7);
                    ASSERT_NEAR(ray.origin[c], eye[c], 2e-7);
                }
                ASSERT_EQ(ray.t_min, 0);
                ASSERT_TRUE(std::isinf(ray.t_max));
                ASSERT_GT(ray.footprint_rad, 0);
            }
            es_sequence_close(sequence);
        }
}

/// Each ray begins on the circle and goes along its tangent; both eyes' rays of a column are parallel.
TEST_F(AbiFilm, omnidirectional_rays_begin_at_eyes_of_their_own) {
    settings.camera = ES_ODS;
    settings.aovs = "depth";
    for (const es_axis_lock lock : {ES_LOCK_WORLD, ES_LOCK_PATH})
        for (const es_eye eye : {ES_EYE_LEFT, ES_EYE_RIGHT}) {
            settings.lock = lock;
            settings.eye = eye;
            settings.overwrite = 1;
            es_sequence* sequence = open();
            const auto all = rays(sequence, at(0, turned, turned, turned), -1);
            const glm::dquat orientation = lock == ES_LOCK_PATH ? turned.orientation : glm::dquat(1, 0, 0, 0);
            const double side_m = eye == ES_EYE_LEFT ? -0.0315 : 0.0315;
            for (int i = 0; i < 72 * 36; ++i) {
                const es_ray& ray = all[static_cast<std::size_t>(i)];
                const double longitude = ((i % 72 + 0.5) / 72 - 0.5) * 2 * pi,
                             latitude = (0.5 - (i / 72 + 0.5) / 36) * pi;
                const glm::dvec3 ahead(std::sin(longitude), 0, -std::cos(longitude));
                const double t = std::clamp((std::abs(latitude) * 180 / pi - 60) / 15, 0.0, 1.0);
                const glm::dvec3 beside(std::cos(longitude), 0, std::sin(longitude));
                const glm::dvec3 from =
                    turned.position_m + orientation * (side_m * (1 + std::cos(pi * t)) / 2 * beside);
                const glm::dvec3 d = orientation * (std::cos(latitude) * ahead + glm::dvec3(0, std::sin(latitude), 0));
                for (int c = 0; c < 3; ++c) {
                    ASSERT_NEAR(ray.origin[c], from[c], 3e-7) << i;
                    ASSERT_NEAR(ray.direction[c], d[c], 3e-7) << i;
                }
            }
            es_sequence_close(sequence);
        }
    settings.eye = ES_EYE_CENTRE;
    EXPECT_NE(refusal().find("eye: expected ES_EYE_LEFT or ES_EYE_RIGHT with ES_ODS"), std::string::npos);
    settings.eye = ES_EYE_LEFT;
    settings.layer = ES_LAYER_HIDDEN;
    EXPECT_NE(refusal().find("no ES_ODS in a hidden layer"), std::string::npos);
}

TEST_F(AbiFilm, omnidirectional_stereo_of_eyes_at_one_place_is_the_plain_sphere) {
    settings.ipd_m = 0;
    settings.eye = ES_EYE_LEFT;
    std::vector<std::vector<es_ray>> found;
    for (const es_camera_kind kind : {ES_EQUIRECT, ES_ODS}) {
        settings.camera = kind;
        settings.overwrite = 1;
        es_sequence* sequence = open();
        for (const int sample : {-1, 2})
            found.push_back(rays(sequence, at(0, turned, turned, turned), sample));
        es_sequence_close(sequence);
    }
    for (const std::size_t k : {0, 1})
        for (std::size_t i = 0; i < found[k].size(); ++i) {
            const es_ray &plain = found[k][i], &ods = found[k + 2][i];
            for (int c = 0; c < 3; ++c) {
                ASSERT_EQ(plain.origin[c], ods.origin[c]);
                ASSERT_EQ(plain.direction[c], ods.direction[c]);
            }
            ASSERT_EQ(plain.seed, ods.seed);
        }
}

/// A sphere around the head: every ray goes sqrt(R^2 - r^2) at the equator, and a point of it is seen by both eyes in
/// directions that differ by twice the angle whose sine is r / R. A still point does not move.
TEST_F(AbiFilm, omnidirectional_stereo_sees_a_sphere_around_it_by_closed_form) {
    constexpr double radius_m = 2;
    settings.camera = ES_ODS;
    settings.aovs = "depth,motion";
    glm::dvec3 directions[2];
    const glm::dvec3 point(radius_m * std::sin(0.7), 0, -radius_m * std::cos(0.7));
    for (const es_eye eye : {ES_EYE_LEFT, ES_EYE_RIGHT}) {
        settings.eye = eye;
        settings.overwrite = 1;
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(0));
        fill(
            frame,
            [](const es_ray& ray) {
                const glm::dvec3 o(ray.origin[0], ray.origin[1], ray.origin[2]),
                    d(ray.direction[0], ray.direction[1], ray.direction[2]);
                const double along = glm::dot(o, d);
                es_surface surface{};
                surface.distance_m = float(-along + std::sqrt(along * along + radius_m * radius_m - glm::dot(o, o)));
                const glm::dvec3 at_m = o + double(surface.distance_m) * d;
                for (int c = 0; c < 3; ++c)
                    surface.position_previous_m[c] = surface.position_next_m[c] = float(at_m[c]);
                return surface;
            },
            [](const es_ray&) { return glm::vec4(1); });
        end(frame);
        es_sequence_close(sequence);
        const Frame made = read(0);
        const auto& camera = std::get<EquirectCamera>(made.info.camera);
        EXPECT_EQ(camera.ods_side_m, eye == ES_EYE_LEFT ? -0.0315 : 0.0315);
        EXPECT_EQ(made.info.camera_pose.position_m, glm::dvec3(0));
        for (int x = 0; x < 72; ++x) {
            const double latitude = 0.5 / 36 * pi;  // just above the equator
            const double height = std::sin(latitude), flat = std::cos(latitude);
            // (side)^2 + (t flat)^2 + (t height)^2 = R^2
            EXPECT_NEAR(*made.planes.at("depth").pixel(x, 17),
                        std::sqrt(radius_m * radius_m - 0.0315 * 0.0315) / std::hypot(height, flat), 1e-6);
        }
        for (const char* plane : {"backward", "forward"})
            for (const float value : made.planes.at(plane).samples())
                EXPECT_NEAR(value, 0, 2e-3) << plane;
        directions[eye == ES_EYE_LEFT ? 0 : 1] = camera.direction_to(point);
        // Along that direction from the eye that looks there lies the point.
        const glm::dvec2 pixel = camera.pixel(directions[eye == ES_EYE_LEFT ? 0 : 1]);
        const glm::dvec3 from = camera.origin(pixel.x, pixel.y);
        EXPECT_NEAR(glm::length(glm::cross(glm::normalize(point - from), camera.direction(pixel.x, pixel.y))), 0, 1e-9);
    }
    const double disparity = longitude_of(Vector3<double>{directions[0].x, directions[0].y, directions[0].z}) -
                             longitude_of(Vector3<double>{directions[1].x, directions[1].y, directions[1].z});
    EXPECT_NEAR(disparity, 2 * std::asin(0.0315 / radius_m), 1e-9);
}

TEST_F(AbiFilm, colour_rays_stay_in_their_pixel_and_fill_it) {
    settings.spp = 64;
    es_sequence* sequence = open();
    const EquirectCamera camera{72, 36, {}};
    std::vector<double> sum_u(72 * 36);
    std::vector<double> sum_v(72 * 36);
    for (int sample = 0; sample < 64; ++sample) {
        const auto all = rays(sequence, at(5), sample);
        for (int i = 0; i < 72 * 36; ++i) {
            const float* d = all[static_cast<std::size_t>(i)].direction;
            const glm::dvec2 p = camera.pixel({d[0], d[1], d[2]});
            // Next to a pole a rounding of the direction is a large step in longitude.
            const double slack = 1e-4 / std::sin(pi * (i / 72 + 0.02) / 36);
            ASSERT_NEAR(shortest_column_difference(p.x - (i % 72 + 0.5), 72, camera.range), 0, 0.5 + slack);
            ASSERT_NEAR(p.y - (i / 72 + 0.5), 0, 0.5 + 1e-4);
            sum_u[static_cast<std::size_t>(i)] += shortest_column_difference(p.x - (i % 72 + 0.5), 72, camera.range);
            sum_v[static_cast<std::size_t>(i)] += p.y - (i / 72 + 0.5);
        }
    }
    // 64 points stratified in both directions: each lies in its own 1/64 of the pixel, so means are within 1/128.
    for (int i = 72; i < 72 * 35; ++i) {
        ASSERT_NEAR(sum_u[static_cast<std::size_t>(i)] / 64, 0, 1.0 / 128 + 1e-3);
        ASSERT_NEAR(sum_v[static_cast<std::size_t>(i)] / 64, 0, 1.0 / 128 + 1e-3);
    }
    es_sequence_close(sequence);
}

TEST_F(AbiFilm, seeds_differ_for_every_pixel_sample_and_frame) {
    es_sequence* sequence = open();
    std::set<std::uint64_t> seeds;
    for (const std::int64_t index : {0, 1})
        for (int sample = -1; sample < 4; ++sample)
            for (const es_ray& ray : rays(sequence, at(index), sample))
                seeds.insert(ray.seed);
    EXPECT_EQ(seeds.size(), 2u * 5 * 72 * 36);
    es_sequence_close(sequence);
}

TEST_F(AbiFilm, threads_change_no_bit) {
    const auto radiance = [](const es_ray& ray) {
        const auto noise = static_cast<float>(ray.seed >> 40) * 0x1p-24f;
        return glm::vec4(noise, std::abs(ray.direction[0]), std::abs(ray.direction[1]), 1);
    };
    const auto surface = [](const es_ray& ray) {
        es_surface s{};
        s.distance_m = 1 + static_cast<float>(ray.seed >> 40) * 0x1p-24f;
        s.object_id = ray.pixel;
        return s;
    };
    es_sequence* sequence = open();
    std::vector<std::string> files;
    for (const int threads : {1, 2, 5}) {
        es_frame* frame = begin(sequence, at(0));
        fill(frame, surface, radiance, threads);
        end(frame);
        files.push_back(file_bytes(output + "/frame.0000.exr"));
    }
    EXPECT_EQ(files[0], files[1]);
    EXPECT_EQ(files[0], files[2]);
    es_sequence_close(sequence);
}

TEST_F(AbiFilm, colour_is_the_mean_of_finite_samples) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    // About half the samples of every pixel are spoiled; those left all agree.
    int spoiled = 0;
    fill(frame, miss, [&](const es_ray& ray) {
        spoiled += ray.seed % 2 == 0;
        return ray.seed % 2 == 0 ? glm::vec4(0.25f, std::nanf(""), 0, 1) : glm::vec4(0.25f, 2, 0, 1);
    });
    end(frame);
    const Frame read_back = read(0);
    const FloatImage& colour = read_back.planes.at("colour");
    int all_spoiled = 0;
    for (int y = 0; y < 36; ++y)
        for (int x = 0; x < 72; ++x) {
            const float* p = colour.pixel(x, y);
            all_spoiled += p[3] == 0;
            ASSERT_TRUE(p[3] == 0 ? p[0] == 0 && p[1] == 0 : p[0] == 0.25f && p[1] == 2.0f && p[3] == 1);
        }
    // One pixel in 2^4 has no good sample: 162 expected, with a standard deviation of 12.
    EXPECT_NEAR(all_spoiled, 162, 60);
    EXPECT_EQ(left_out_noted(0), std::to_string(spoiled));
    frame = begin(sequence, at(1));
    fill(frame, miss, black);
    end(frame);
    EXPECT_EQ(left_out_noted(1), "") << "nothing to note";
    es_sequence_close(sequence);
}

TEST_F(AbiFilm, misses_have_infinite_depth_and_nothing_else) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0, {{5, 5, 5}, {1, 0, 0, 0}}));
    fill(
        frame,
        [](const es_ray& ray) {
            es_surface s{};
            s.distance_m = ray.pixel % 3 == 0 ? std::nanf("") : ray.pixel % 3 == 1 ? -1.0f : INFINITY;
            s.object_id = 9;
            s.normal[0] = 1;
            return s;
        },
        black);
    end(frame);
    const Frame read_back = read(0);
    for (const auto& [name, image] : read_back.planes)
        for (const float v : image.samples())
            ASSERT_TRUE(name.ends_with("depth") ? std::isinf(v) && v > 0 : std::abs(v) < 1e-9) << name << " " << v;
    for (const auto& [name, image] : read_back.ids)
        for (const std::uint32_t v : image.samples())
            ASSERT_EQ(v, 0u) << name;
    es_sequence_close(sequence);
}

TEST_F(AbiFilm, only_the_wanted_planes_are_written) {
    settings.aovs = "depth";
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    fill(frame, miss, black);
    end(frame);
    const Frame read_back = read(0);
    EXPECT_EQ(read_back.planes.size(), 2u);
    EXPECT_TRUE(read_back.ids.empty());
    es_sequence_close(sequence);
}

es_plane plane_of(const char* name, const FloatImage& image) {
    return {sizeof(es_plane),  name,
            ES_FLOAT32,        image.channels(),
            image.pixel(0, 0), static_cast<std::size_t>(image.width()) * image.channels() * 4};
}

TEST_F(AbiFilm, whole_planes_take_the_place_of_tiles) {
    settings.aovs = "depth,ids";
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    es_error error{};
    // A plane with padded rows, as hosts have them.
    std::vector<float> colour(static_cast<std::size_t>(80 * 4 * 36), 7.0f);
    es_plane plane{sizeof(es_plane), "colour", ES_FLOAT32, 4, colour.data(), 80 * 4 * 4};
    ASSERT_EQ(es_frame_put_plane(frame, &plane, &error), ES_OK) << error.text;
    const FloatImage depth(72, 36, 1, 2.5f);
    plane = plane_of("depth", depth);
    ASSERT_EQ(es_frame_put_plane(frame, &plane, &error), ES_OK) << error.text;
    EXPECT_NE(es_sequence_has_frame(sequence, 0), 1);
    for (const char* name : {"object_id", "material_id", "instance_id"}) {
        const IdImage ids(72, 36, 1, 5);
        plane = {sizeof(es_plane), name, ES_UINT32, 1, ids.pixel(0, 0), 72 * 4};
        ASSERT_EQ(es_frame_put_plane(frame, &plane, &error), ES_OK) << error.text;
    }
    end(frame);
    const Frame read_back = read(0);
    EXPECT_EQ(read_back.planes.at("colour").pixel(71, 35)[3], 7.0f);
    EXPECT_EQ(read_back.planes.at("depth").pixel(71, 35)[0], 2.5f);
    EXPECT_EQ(read_back.ids.at("instance_id").pixel(3, 3)[0], 5u);
    es_sequence_close(sequence);
}

/// Noise, also some that is not finite.
glm::vec4 noise_with_holes(const es_ray& ray) {
    const auto noise = static_cast<float>(ray.seed >> 40) * 0x1p-24f;
    return {noise < 0.1f ? std::numeric_limits<float>::quiet_NaN() : noise, std::abs(ray.direction[0]), noise * noise,
            1};
}

es_surface numbered(const es_ray& ray) {
    es_surface s{};
    s.distance_m = 1 + static_cast<float>(ray.seed >> 40) * 0x1p-24f;
    s.object_id = ray.pixel;
    return s;
}

TEST_F(AbiFilm, parts_put_together_are_the_frame) {
    settings.aovs = "all";
    const auto rendered = [&](std::uint32_t part, std::uint32_t count) {
        settings.part = part;
        settings.part_count = count;
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(0));
        fill(frame, numbered, noise_with_holes, 2);
        end(frame);
        EXPECT_EQ(es_sequence_has_frame(sequence, 0), 1);
        es_sequence_close(sequence);
    };
    rendered(0, 0);
    const std::string file = output + "/frame.0000.exr", whole = file_bytes(file);
    for (const std::uint32_t count : {1u, 4u, 50u}) {  // of which many have no tile
        std::filesystem::remove(file);
        for (std::uint32_t part = count; part > 0; --part)
            rendered(part, count);
        EXPECT_FALSE(std::filesystem::exists(file));
        settings.part = 0;
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(0));
        const FloatImage colour(72, 36, 4, 1.0f);
        const es_plane plane = plane_of("colour", colour);
        es_error error{};
        EXPECT_EQ(es_frame_put_plane(frame, &plane, &error), ES_BAD_INPUT) << "a plane that no part has";
        es_frame_discard(frame);
        es_sequence_close(sequence);
        rendered(0, count);
        EXPECT_TRUE(file_bytes(file) == whole) << count << " parts";
        EXPECT_FALSE(std::filesystem::exists(output + "/part-1-of-" + std::to_string(count)));
    }
}

TEST_F(AbiFilm, parts_that_do_not_belong_together_are_refused) {
    settings.part_count = 1;
    settings.part = 1;
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    fill(frame, numbered, noise_with_holes);
    end(frame);
    es_sequence_close(sequence);
    settings.part = 0;
    settings.seed = 12;
    sequence = open();
    es_error error{};
    const es_frame_settings when = at(0);
    EXPECT_EQ(es_frame_begin(sequence, &when, &frame, &error), ES_BAD_INPUT);
    EXPECT_NE(std::string(error.text).find("part-1-of-1/frame.0000.part: expected 'equistream part 2: frame 0"),
              std::string::npos)
        << error.text;
    es_sequence_close(sequence);
}

TEST_F(AbiFilm, parts_of_other_tiles_are_refused_and_those_of_other_settings_make_way) {
    settings.part_count = settings.part = 1;
    const auto rendered = [&](std::int64_t index) {
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(index));
        fill(frame, numbered, noise_with_holes);
        end(frame);
        es_sequence_close(sequence);
    };
    rendered(0);
    rendered(1);
    settings.tile_side = 16;
    es_sequence* sequence = open();
    EXPECT_EQ(es_sequence_has_frame(sequence, 0), 0);
    es_sequence_close(sequence);
    settings.seed = 12;
    settings.overwrite = 1;
    rendered(1);
    EXPECT_EQ(list_frames(output + "/part-1-of-1", "part"), std::vector<std::int64_t>{1});
}

TEST_F(AbiFilm, a_part_beside_whole_frames_of_other_settings_is_refused) {
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    fill(frame, numbered, noise_with_holes);
    end(frame);
    es_sequence_close(sequence);
    settings.part_count = settings.part = 1;
    settings.seed = 12;
    es_error error{};
    EXPECT_EQ(es_sequence_open(&settings, &sequence, &error), ES_BAD_INPUT);
    EXPECT_NE(std::string(error.text).find("manifest.json: expected seed"), std::string::npos) << error.text;
}

TEST_F(AbiFilm, a_part_has_no_whole_planes) {
    settings.aovs = "none";
    settings.part_count = 2;
    for (settings.part = 1; settings.part <= 2; ++settings.part) {
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(0));
        const FloatImage colour(72, 36, 4, 1.0f);
        const es_plane plane = plane_of("colour", colour);
        es_error error{};
        EXPECT_EQ(es_frame_put_plane(frame, &plane, &error), ES_BAD_INPUT) << settings.part;
        EXPECT_STREQ(error.text, "es_frame_put_plane: expected planes given tile by tile, as frames are in parts, "
                                 "found the whole plane colour");
        es_frame_discard(frame);
        es_sequence_close(sequence);
    }
}

TEST_F(AbiFilm, wrong_planes_are_refused) {
    settings.aovs = "depth,motion";
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(0));
    const auto expect = [&](const es_plane& plane, const std::string& line) {
        es_error error{};
        EXPECT_EQ(es_frame_put_plane(frame, &plane, &error), ES_BAD_INPUT);
        EXPECT_EQ(std::string(error.text), line);
    };
    FloatImage depth(72, 36, 1, 1.0f);
    es_plane plane = plane_of("heat", depth);
    expect(plane, "es_plane.name: expected one of colour, depth, backward, forward, found \"heat\"");
    plane = plane_of("depth", depth);
    plane.channels = 2;
    expect(plane, "plane depth: channels: expected 1, found 2");
    plane = plane_of("depth", depth);
    plane.type = ES_UINT32;
    expect(plane, "plane depth: type: expected ES_FLOAT32, found 1");
    plane = plane_of("depth", depth);
    plane.row_stride_bytes = 71 * 4;
    expect(plane, "plane depth: row_stride_bytes: expected at least 288, found 284");
    depth.pixel(3, 2)[0] = std::nanf("");
    expect(plane_of("depth", depth), "plane depth at pixel 3,2: expected a distance, +inf for a miss, found nan");
    FloatImage motion(72, 36, 2, 0.0f);
    motion.pixel(70, 35)[1] = INFINITY;
    expect(plane_of("backward", motion), "plane backward at pixel 70,35: expected a finite number, found inf");
    es_frame_discard(frame);
    es_sequence_close(sequence);
}

/// A sphere of 5 m around the origin whose radiance is 1 with much noise.
es_surface ball(const es_ray& ray) {
    es_surface surface{};
    const glm::dvec3 origin_m(ray.origin[0], ray.origin[1], ray.origin[2]);
    const glm::dvec3 direction(ray.direction[0], ray.direction[1], ray.direction[2]);
    const double b = glm::dot(origin_m, direction);
    const double distance_m = -b + std::sqrt(b * b - glm::dot(origin_m, origin_m) + 25);
    surface.distance_m = static_cast<float>(distance_m);
    const glm::vec3 point(origin_m + distance_m * direction);
    for (int axis = 0; axis < 3; ++axis) {
        surface.position_previous_m[axis] = surface.position_next_m[axis] = point[axis];
        surface.normal[axis] = -point[axis] / 5;
    }
    surface.object_id = surface.material_id = surface.instance_id = 1;
    return surface;
}
glm::vec4 noisy(const es_ray& ray) {
    const float level = 2 * static_cast<float>(ray.seed >> 40) * 0x1p-24f;
    return {level, level, level, 1};
}

TEST_F(AbiFilm, frames_are_accumulated_along_the_way_of_the_head) {
    settings.accumulate_frames = 16;
    settings.aovs = "samples,variance";
    es_sequence* sequence = open();
    std::int64_t last = 0;
    Pose head;
    const auto accumulated = [&](es_frame_settings when, double to_m) {
        const Pose next{{to_m, 0, 0}, {1, 0, 0, 0}};
        when.head_previous = pose_of(head);
        when.head = when.head_next = pose_of(next);
        es_frame* frame = begin(sequence, when);
        fill(frame, ball, noisy, 2);
        end(frame);
        head = next;
        last = when.index;
        return read(last);
    };
    const auto mean = [](const Frame& frame, const char* plane, std::size_t step = 1) {
        double sum = 0;
        const auto values = frame.planes.at(plane).samples();
        for (std::size_t i = 0; i < values.size(); i += step)
            sum += double(values[i]);
        return sum / double(values.size() / step);
    };
    Frame frame = accumulated(at(0), 0);
    EXPECT_EQ(mean(frame, "samples"), 4);
    EXPECT_EQ(frame.planes.size(), 3u);
    EXPECT_TRUE(frame.ids.empty());
    accumulated(at(1), 0.1);
    frame = accumulated(at(2), 0.1);
    EXPECT_NEAR(mean(frame, "samples"), 12, 0.3);
    EXPECT_NEAR(mean(frame, "colour", 4), 1, 3 * 0.577 / std::sqrt(12 * 72 * 36));
    EXPECT_NEAR(mean(frame, "variance") / (1.0 / 3 / 12), 1, 0.2);
    // Another number of samples, some frames later.
    es_frame_settings when = at(7);
    when.spp = 2;
    when.previous_frames = 5;
    frame = accumulated(when, 0.1);
    EXPECT_EQ(frame.info.samples_per_pixel, 2u);
    EXPECT_NEAR(mean(frame, "samples"), 14, 0.4);
    // Motion that leads to another frame than the last.
    frame = accumulated(at(9), 0.1);
    EXPECT_NEAR(mean(frame, "samples"), 4, 0.01);
    es_sequence_close(sequence);
    EXPECT_EQ(read_exr_info(output + "/" + frame_file_name(9)).accumulated_frames, 16u);
    EXPECT_EQ(read_manifest(output).shared.accumulated_frames, 16u);
    settings.accumulate_frames = 0;
    settings.aovs = "none";
    EXPECT_NE(refusal().find("expected"), std::string::npos);
}

TEST_F(AbiFilm, what_cannot_be_accumulated_is_refused) {
    settings.accumulate_frames = 16;
    settings.layer = ES_LAYER_HIDDEN;
    EXPECT_EQ(refusal(), "accumulate_frames: expected 0 in a hidden layer and in an atlas of patches, found 16");
    settings.accumulate_frames = 0;
    settings.layer = ES_LAYER_FIRST;
    es_sequence* sequence = open();
    es_frame_settings when = at(0);
    when.spp = 2;
    es_frame* frame = nullptr;
    es_error error{};
    EXPECT_EQ(es_frame_begin(sequence, &when, &frame, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "es_frame_settings.spp: expected 0 in a sequence of independent frames, found 2");
    es_sequence_close(sequence);
}

}  // namespace
}  // namespace equistream::testing
