// Windows: where they are on their sphere, and through the C ABI a base that shows what they show.
#include "abi/abi_fixture.h"

#include <equistream/camera_limits.h>
#include <equistream/window.h>

#include <algorithm>
#include <random>

namespace equistream::testing {
namespace {

constexpr WindowGrid grids[] = {{1920, 960, 320, 256}, {384, 192, 64, 48}, {96, 48, 80, 48}, {64, 32, 16, 16}};

glm::dvec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

TEST(Window, holds_the_gaze_and_lies_on_whole_blocks_of_its_sphere) {
    std::mt19937 random(1);
    for (const WindowGrid& grid : grids) {
        EXPECT_FALSE(window_grid_problem(grid));
        const EquirectCamera sphere{grid.columns, grid.rows, {}};
        for (int i = 0; i < 2000; ++i) {
            const glm::dvec3 gaze = i < 2 ? glm::dvec3(0, i == 0 ? 1 : -1, 0) : random_direction(random);
            const WindowPlace place = window_around(grid, gaze);
            ASSERT_FALSE(window_place_problem(grid, place)) << place.x << ", " << place.y;
            const EquirectCamera window = window_camera(grid, place);
            ASSERT_FALSE(camera_mismatch(window)) << place.x << ", " << place.y;
            ASSERT_EQ(window_place(grid, window.range), place);
            const glm::dvec2 at = window.pixel(gaze);
            ASSERT_TRUE(at.x >= 0 && at.x <= grid.width && at.y >= 0 && at.y <= grid.height) << at.x << ", " << at.y;
            const double u = 0.37 * grid.width, v = 0.61 * grid.height;
            ASSERT_LT(glm::distance(window.direction(u, v), sphere.direction(place.x + u, place.y + v)), 1e-12);
        }
    }
}

TEST(Window, goes_on_across_the_seam_and_ends_at_the_poles) {
    const WindowGrid grid = grids[1];
    const WindowPlace behind = window_around(grid, {0, 0, 1});
    EXPECT_EQ(behind.x, 352);
    const EquirectCamera camera = window_camera(grid, behind);
    for (const double turn : {-0.4, -0.001, 0.001, 0.4}) {
        const glm::dvec2 at = camera.pixel({-std::sin(turn), 0, std::cos(turn)});
        EXPECT_NEAR(at.x, 32 + turn * 384 / (2 * pi), 1e-9);
        EXPECT_NEAR(at.y, 96 - behind.y, 1e-9);
    }
    EXPECT_EQ(window_around(grid, {0, 1, 0}).y, 0);
    EXPECT_EQ(window_around(grid, {0, -1, 0}).y, 192 - 48);
    LongitudeLatitudeRange off = window_range(grid, {16, 32});
    off.longitude_min += 0.001;
    EXPECT_FALSE(window_place(grid, off)) << "between two columns";
}

TEST(Window, problems_are_named) {
    EXPECT_EQ(window_grid_problem({100, 50, 16, 16}),
              "density: expected columns of a sphere in multiples of 16, twice its rows, found 100x50");
    EXPECT_EQ(window_grid_problem({96, 48, 20, 16}),
              "window: expected a width and a height in multiples of 16 pixels, found 20x16");
    EXPECT_EQ(window_grid_problem({96, 48, 96, 16}), "window: expected less than the sphere's 96x48, found 96x16");
    EXPECT_EQ(window_grid(384, 60 * pi / 180, 45 * pi / 180), grids[1]);
    EXPECT_EQ(window_grid(384, 1e9, 1e9), (WindowGrid{384, 192, 384, 192}));
}

TEST(Window, half_the_pixels_cover_at_least_the_same_angles) {
    const WindowGrid grid{3840, 1920, 960, 640};
    EXPECT_EQ(halved_window_grid(grid, 0), grid);
    EXPECT_EQ(halved_window_grid(grid, 2), (WindowGrid{1920, 960, 480, 320}));
    for (const int halvings : {1, 3}) {
        const WindowGrid halved = halved_window_grid(grid, halvings);
        EXPECT_EQ(window_grid_problem(halved), std::nullopt);
        EXPECT_NEAR(halved.columns, grid.columns * std::exp2(-0.5 * halvings), window_block_px);
        for (const auto side : {&WindowGrid::width, &WindowGrid::height}) {
            const double cover = double(halved.*side) / halved.columns * grid.columns / (grid.*side);
            EXPECT_GE(cover, 1 - 1e-9);
            EXPECT_LT(cover, 1.06);
        }
    }
}

TEST(Window, follows_a_gaze_only_when_it_nears_the_border) {
    const WindowGrid grid = grids[0];
    WindowFollower follower(grid);
    EXPECT_EQ(WindowFollower::slack_px(grid.width), 40);
    EXPECT_EQ(WindowFollower::slack_px(grid.height), 32);
    EXPECT_EQ(WindowFollower::slack_px(48), 16);
    const auto at = [](double degrees) {
        return glm::dvec3(std::sin(degrees * pi / 180), 0, -std::cos(degrees * pi / 180));
    };
    const WindowPlace first = follower.place(at(0));
    EXPECT_EQ(first, window_around(grid, at(0)));
    EXPECT_EQ(follower.place(at(6)), first) << "32 pixels";
    EXPECT_EQ(follower.place(at(-6)), first);
    const WindowPlace second = follower.place(at(9));
    EXPECT_EQ(second, window_around(grid, at(9))) << "48 pixels";
    EXPECT_EQ(follower.place(at(3)), second) << "and stays there";
    const WindowPlace behind = follower.place(at(179));
    EXPECT_EQ(follower.place(at(-178)), behind) << "the seam is no border";
}

TEST(Window, covers_the_pixels_that_lie_within_it_and_gives_them_their_mean) {
    std::mt19937 random(2);
    for (const WindowGrid& grid : grids)
        for (const int width : {grid.columns / 12, 40}) {
            const int height = width / 2;
            const WindowPlace place = window_around(grid, random_direction(random));
            const WindowCover cover(grid, place, width, height);
            FloatImage window(grid.width, grid.height, 1), base(width, height, 1, -1.0f);
            for (float& sample : window.samples())
                sample = std::uniform_real_distribution<float>(0, 1)(random);
            cover.put(window.view(), base.view());
            // Each pixel of the window, by how much of it the base's pixel has.
            const auto share = [](int pixel, double of, double size) {
                return std::max(0.0, std::min(pixel + 1.0, of + size) - std::max(double(pixel), of)) / size;
            };
            const double wide = static_cast<double>(grid.columns) / width,
                         high = static_cast<double>(grid.rows) / height;
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x) {
                    double mean = 0, whole = 0;
                    for (int row = 0; row < grid.height; ++row) {
                        const double of_row = share(place.y + row, y * high, high);
                        for (int column = 0; column < grid.width && of_row > 0; ++column) {
                            const double area = of_row * share((place.x + column) % grid.columns, x * wide, wide);
                            whole += area;
                            mean += area * double(*window.pixel(column, row));
                        }
                    }
                    ASSERT_EQ(cover.covers(x, y), whole > 1 - 1e-9) << x << ", " << y;
                    ASSERT_NEAR(double(*base.pixel(x, y)), cover.covers(x, y) ? mean : -1, 1e-6);
                }
        }
}

/// A window of 96x64 on a sphere of 384x192, over its seam, in a base of 96x48 that is rendered in tiles of 8x8.
class WindowInBaseTest : public AbiTest {
protected:
    void SetUp() override {
        AbiTest::SetUp();
        settings.aovs = "depth";
        settings.tile_side = 8;
    }
    es_sequence* open_in(const char* name, int width, int height, std::int64_t window_columns = 0) {
        folder_ = output + "/" + name;
        settings.output_dir = folder_.c_str();
        settings.width = width;
        settings.height = height;
        settings.window_columns = window_columns;
        return open();
    }
    es_sequence* open_window() { return open_in("window", 96, 64, 384); }
    es_sequence* open_base() { return open_in("base", 96, 48); }
    static es_frame_settings window_at(std::int64_t index, int x = 368, int y = 64) {
        es_frame_settings when = at(index);
        when.window_x = x;
        when.window_y = y;
        return when;
    }
    static es_frame_settings around(const es_sequence* window, std::int64_t index) {
        es_frame_settings when = at(index);
        when.window = window;
        return when;
    }
    static void finish(es_frame* frame) {
        fill(frame, surface, radiance);
        end(frame);
    }
    static std::string refusal_of(es_sequence* sequence, const es_frame_settings& when) {
        es_frame* frame = nullptr;
        es_error error{};
        EXPECT_EQ(es_frame_begin(sequence, &when, &frame, &error), ES_BAD_INPUT);
        return error.text;
    }
    Frame read(const char* name, std::int64_t index) const {
        return read_exr(output + "/" + name + "/" + frame_file_name(index));
    }
    static es_surface surface(const es_ray& ray) {
        es_surface s{};
        s.distance_m = 2 + ray.direction[0] + 0.5f * ray.direction[1];
        return s;
    }
    static glm::vec4 radiance(const es_ray& ray) {
        const float* d = ray.direction;
        return {std::abs(std::sin(40 * d[0])), std::abs(std::sin(30 * d[1])), d[2] * d[2], d[1] > 0};
    }
    static bool is_within(int x, int y) { return (x >= 92 || x < 20) && y >= 16 && y < 32; }

private:
    std::string folder_;
};

TEST_F(WindowInBaseTest, shows_the_windows_mean_and_is_not_sampled_there) {
    es_sequence* const window = open_window();
    es_frame* const window_frame = begin(window, window_at(3));
    es_sequence* const base = open_base();
    es_frame* const frame = begin(base, around(window, 3));
    finish(window_frame);
    es_tile tile{};
    int without = 0;
    std::vector<es_ray> rays(64);
    std::vector<es_surface> surfaces(64);
    std::vector<float> rgba(256);
    while (es_frame_next_tile(frame, &tile) == ES_OK) {
        const bool whole = is_within(tile.x, tile.y) && is_within(tile.x + 7, tile.y);
        EXPECT_EQ(tile.sample_count, whole ? 0u : settings.spp) << tile.x << ", " << tile.y;
        without += whole;
        es_tile_geometry_rays(frame, &tile, rays.data());
        std::ranges::transform(rays, surfaces.begin(), surface);
        es_tile_put_surfaces(frame, &tile, surfaces.data());
        for (std::uint32_t pass = 0; pass < tile.sample_count; ++pass) {
            es_tile_colour_rays(frame, &tile, pass, rays.data());
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const glm::vec4 colour = radiance(rays[i]);
                std::copy_n(&colour.x, 4, &rgba[4 * i]);
            }
            es_tile_put_radiance(frame, &tile, rgba.data());
        }
    }
    EXPECT_EQ(without, 4);
    end(frame);

    const FloatImage seen = read("window", 3).planes.at("colour"), shown = read("base", 3).planes.at("colour");
    es_sequence* const alone = open_in("alone", 96, 48);
    finish(begin(alone, at(3)));
    const Frame rendered = read("alone", 3);
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 96; ++x)
            for (int c = 0; c < 4; ++c) {
                if (!is_within(x, y)) {
                    ASSERT_EQ(shown.pixel(x, y)[c], rendered.planes.at("colour").pixel(x, y)[c]) << x << ", " << y;
                    continue;
                }
                double mean = 0;
                for (int i = 0; i < 16; ++i)
                    mean += double(seen.pixel((4 * x + i % 4 + 16) % 384, 4 * y - 64 + i / 4)[c]) / 16;
                ASSERT_NEAR(double(shown.pixel(x, y)[c]), mean, 5e-4 * mean + 1e-6) << x << ", " << y;  // half floats
            }
    EXPECT_TRUE(
        std::ranges::equal(read("base", 3).planes.at("depth").samples(), rendered.planes.at("depth").samples()));
    for (es_sequence* sequence : {window, base, alone})
        es_sequence_close(sequence);

    // The window is kept, and the base rendered anew.
    std::filesystem::remove(output + "/base/" + frame_file_name(3));
    es_sequence *kept = open_window(), *again = open_base();
    finish(begin(again, around(kept, 3)));
    es_sequence_close(kept);
    es_sequence_close(again);
    EXPECT_TRUE(std::ranges::equal(read("base", 3).planes.at("colour").samples(), shown.samples()));
}

TEST_F(WindowInBaseTest, has_the_rays_of_its_whole_sphere) {
    es_sequence* const window = open_window();
    finish(begin(window, window_at(0)));
    es_sequence* const sphere = open_in("sphere", 384, 192);
    finish(begin(sphere, at(0)));
    for (const char* plane : {"colour", "depth"}) {
        const FloatImage part = read("window", 0).planes.at(plane), whole = read("sphere", 0).planes.at(plane);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 96; ++x)
                for (int c = 0; c < part.channels(); ++c)
                    ASSERT_EQ(part.pixel(x, y)[c], whole.pixel((x + 368) % 384, y + 64)[c]) << x << ", " << y;
    }
    es_sequence_close(window);
    es_sequence_close(sphere);
}

TEST_F(WindowInBaseTest, wherever_it_is_its_frames_are_of_one_render) {
    es_sequence* window = open_window();
    finish(begin(window, window_at(0)));
    finish(begin(window, window_at(1, 0, 0)));
    es_sequence_close(window);
    const Manifest manifest = read_manifest(output + "/window");
    EXPECT_EQ(manifest.shared.window_columns, 384);
    OneRender render(output + "/window");
    Frame moved = read("window", 1);
    EXPECT_EQ(std::get<EquirectCamera>(moved.info.camera).range.latitude_max, pi / 2);
    render.require("0", read("window", 0).info);
    render.require("1", moved.info);
    moved.info.window_columns = 0;
    EXPECT_THROW(render.require("1", moved.info), InputError);
    es_sequence_close(open_window());
    settings.window_columns = 416;
    EXPECT_NE(refusal().find("found"), std::string::npos) << "of a denser sphere";
}

TEST_F(WindowInBaseTest, what_does_not_fit_is_named) {
    es_sequence *window = open_window(), *base = open_base();
    const std::string place =
        "es_frame_settings: window_x, window_y: expected multiples of 16, up to 368 and 128, found ";
    EXPECT_EQ(refusal_of(window, window_at(0, 8, 0)), place + "8, 0");
    EXPECT_EQ(refusal_of(window, window_at(0, 384, 0)), place + "384, 0");
    EXPECT_EQ(refusal_of(window, window_at(0, 0, 144)), place + "0, 144");
    EXPECT_EQ(refusal_of(base, window_at(0, 16, 0)),
              "es_frame_settings: window_x, window_y: expected 0 in a sequence that is not of windows, found 16, 0");
    EXPECT_EQ(refusal_of(base, around(base, 0)), "window: expected a sequence of windows, found one of whole pictures");
    EXPECT_EQ(refusal_of(base, around(window, 0)),
              "window: expected a sequence that has begun frame 0 or keeps it, found no frame");
    es_frame* const unfinished = begin(window, window_at(0));
    EXPECT_EQ(refusal_of(base, around(window, 1)),
              "window: expected a sequence that has begun frame 1 or keeps it, found frame 0");
    es_frame_settings elsewhere = around(window, 0);
    elsewhere.head.position_m[0] = 1;
    EXPECT_EQ(refusal_of(base, elsewhere), "window: expected the base's head, found another one");
    es_frame* const early = begin(base, around(window, 0));
    fill(early, surface, radiance);
    es_error error{};
    EXPECT_EQ(es_frame_end(early, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "window: expected its frame ended before the base's, found one that is not written");
    settings.eye = ES_EYE_LEFT;
    es_sequence* const left = open_in("left", 96, 48);
    EXPECT_EQ(refusal_of(left, around(window, 0)), "window: expected the base's eye, found another one");
    settings.eye = ES_EYE_CENTRE;
    es_sequence* const dense = open_in("dense", 384, 192);
    EXPECT_EQ(refusal_of(dense, around(window, 0)),
              "window: expected one of a denser sphere than 384x192, found 384x192");
    es_frame_discard(unfinished);
    for (es_sequence* sequence : {window, base, left, dense})
        es_sequence_close(sequence);
}

TEST_F(WindowInBaseTest, wrong_settings_of_windows_are_named) {
    settings.width = settings.height = 64;
    settings.window_columns = 40000;
    EXPECT_EQ(refusal(), "window_columns: expected 0, or 16 to 32768, found 40000");
    settings.window_columns = 384;
    settings.longitude_max = 1;
    EXPECT_EQ(refusal(), "longitude_min to latitude_max: expected 0 in a sequence of windows, found 1");
    settings.longitude_max = 0;
    settings.layer = ES_LAYER_HIDDEN;
    EXPECT_EQ(refusal(), "window_columns: expected 0 in a hidden layer and in an atlas of patches, found 384");
    settings.layer = ES_LAYER_FIRST;
    settings.width = 60;
    EXPECT_EQ(refusal(), "es_sequence_settings: window: expected a width and a height in multiples of 16 pixels, "
                         "found 60x64");
    settings.camera = ES_PERSPECTIVE;
    EXPECT_EQ(refusal(), "window_columns: expected 0 with a camera that is not ES_EQUIRECT, found 384");
}

}  // namespace
}  // namespace equistream::testing
