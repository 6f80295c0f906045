// host-adapters/example compiled as an outside consumer would, with a plain compiler call on the C header; run; and its
// frames checked against closed forms written down here on their own.
#include <tests/unit/plugin/export/frame_fixture.h>

#include <cstdlib>

namespace equistream::testing {
namespace {

constexpr double floor_y = -1, ball_radius = 0.8;

glm::dvec3 camera_at(int frame) {
    return {0, 0.2, -0.1 * frame};
}

/// Longitude and latitude by arc sine and arc cosine: not the formulas under test.
glm::dvec3 direction_at(double x, double y) {
    const double longitude = (x / 256 - 0.5) * 2 * pi;
    const double latitude = (0.5 - y / 128) * pi;
    return {std::cos(latitude) * std::sin(longitude), std::sin(latitude), -std::cos(latitude) * std::cos(longitude)};
}

glm::dvec2 pixel_at(const glm::dvec3& v) {
    const double latitude = std::asin(v.y / glm::length(v));
    const double from_forward = std::acos(-v.z / std::hypot(v.x, v.z));
    const double longitude = v.x < 0 ? -from_forward : from_forward;
    return {(longitude / (2 * pi) + 0.5) * 256, (0.5 - latitude / pi) * 128};
}

struct Seen {
    std::uint32_t id = 0;  // 1: floor, 2: ball
    double distance = std::numeric_limits<double>::infinity();
    bool near_an_edge = false;
};

Seen expected_at(int frame, const glm::dvec3& d) {
    const glm::dvec3 o = camera_at(frame);
    Seen seen;
    const double t_floor = (floor_y - o.y) / d.y;
    if (t_floor > 0 && t_floor < 50)
        seen = {1, t_floor, false};
    const glm::dvec3 to = o - glm::dvec3(0.4 * frame, 0, -3);
    const double b = glm::dot(to, d);
    const double discriminant = b * b - glm::dot(to, to) + ball_radius * ball_radius;
    if (discriminant >= 0 && -b - std::sqrt(discriminant) < seen.distance && b < 0)
        seen = {2, -b - std::sqrt(discriminant), false};
    // Where a rounding decides what is hit.
    seen.near_an_edge = std::abs(discriminant) < 1e-4 || std::abs(t_floor - 50) < 1e-2;
    return seen;
}

class Example : public FolderTest {
protected:
    void SetUp() override {
        FolderTest::SetUp();
        const std::string sources = EXAMPLE_FOLDER "/toy_host.c " EXAMPLE_FOLDER "/toy_renderer.c";
        const std::string compile = EXAMPLE_COMPILER " -std=c11 -pedantic -O1 -Wall -Wextra -Werror " + sources +
                                    " -I" EXAMPLE_INCLUDE " -L" EXAMPLE_LIBRARY_DIR
                                    " -lequistream -lm -Wl,-rpath," EXAMPLE_LIBRARY_DIR " -o " +
                                    program();
        ASSERT_EQ(std::system(compile.c_str()), 0) << compile;
        ASSERT_EQ(run(folder / "out"), 0);
    }
    std::string program() const { return (folder / "toy_host").string(); }
    int run(const std::filesystem::path& out, const std::string& redirection = "") const {
        return WEXITSTATUS(std::system((program() + " " + out.string() + redirection).c_str()));
    }
    Frame read(int frame) const { return read_exr(folder / "out" / frame_file_name(frame)); }
};

TEST_F(Example, frames_are_what_the_formulas_say) {
    for (const int frame : {0, 1}) {
        const Frame image = read(frame);
        EXPECT_EQ(image.info.camera_pose.position_m, camera_at(frame));
        int counts[3] = {};
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 256; ++x) {
                const glm::dvec3 d = direction_at(x + 0.5, y + 0.5);
                const Seen seen = expected_at(frame, d);
                if (seen.near_an_edge)
                    continue;
                ++counts[seen.id];
                ASSERT_EQ(*image.ids.at("object_id").pixel(x, y), seen.id) << x << "," << y;
                const float depth = *image.planes.at("depth").pixel(x, y);
                const float* motion = image.planes.at("backward").pixel(x, y);
                const glm::dvec3 point = camera_at(frame) + seen.distance * d;
                glm::dvec3 before = point - glm::dvec3(seen.id == 2 ? 0.4 : 0, 0, 0);
                if (seen.id == 0) {
                    ASSERT_TRUE(std::isinf(depth) && depth > 0);
                    ASSERT_NEAR(motion[0], 0, 1e-9);
                    ASSERT_NEAR(motion[1], 0, 1e-9);
                    continue;
                }
                ASSERT_NEAR(depth, seen.distance, 2e-5 * seen.distance);
                const glm::dvec2 moved = pixel_at(before - camera_at(frame - 1)) - glm::dvec2(x + 0.5, y + 0.5);
                ASSERT_NEAR(motion[0] - moved.x - 256 * std::round((motion[0] - moved.x) / 256), 0, 0.02);
                ASSERT_NEAR(motion[1], moved.y, 0.002);
            }
        EXPECT_GT(counts[0], 10000);
        EXPECT_GT(counts[1], 10000);
        EXPECT_GT(counts[2], 300);
    }
}

TEST_F(Example, straight_down_is_the_height_above_the_floor) {
    const Frame image = read(0);
    for (int x = 0; x < 256; x += 16)
        EXPECT_NEAR(*image.planes.at("depth").pixel(x, 127), 1.2 / std::cos(pi / 256), 1e-5);
    EXPECT_EQ(image.planes.at("normal").pixel(10, 120)[1], 1.0f);
    // Floor colours: albedo 0.7 or 0.1 under sun and sky light; alpha 1.
    const float* p = image.planes.at("colour").pixel(0, 127);
    EXPECT_TRUE(std::abs(p[0] - 0.7 * 1.9) < 2e-3 || std::abs(p[0] - 0.1 * 1.9) < 2e-3) << p[0];
    EXPECT_EQ(p[3], 1.0f);
    EXPECT_EQ(image.planes.at("colour").pixel(0, 0)[3], 0.0f);
}

TEST_F(Example, a_second_run_keeps_the_frames) {
    const auto file = folder / "out" / "frame.0001.exr";
    const auto before = std::filesystem::last_write_time(file);
    ASSERT_EQ(run(folder / "out"), 0);
    EXPECT_EQ(std::filesystem::last_write_time(file), before);
}

TEST_F(Example, bad_input_is_one_line_and_exit_2) {
    put_bytes(folder / "file", "");
    EXPECT_EQ(run(folder / "file", " 2> " + (folder / "log").string()), 2);
    const std::string log = file_bytes(folder / "log");
    EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
}

TEST(ExampleRenderer, is_sixty_lines_that_know_nothing_of_equistream) {
    const std::string text =
        file_bytes(EXAMPLE_FOLDER "/toy_renderer.h") + file_bytes(EXAMPLE_FOLDER "/toy_renderer.c");
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 60);
    EXPECT_GE(std::count(text.begin(), text.end(), '\n'), 30);
    for (const char* word : {"equistream", "es_"})
        EXPECT_EQ(text.find(word), std::string::npos) << word;
}

}  // namespace
}  // namespace equistream::testing
