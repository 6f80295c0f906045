#include <tests/unit/scenes/temporary_folder.h>

#include <scenes/library/scene.h>

#include <cmath>
#include <limits>

namespace equistream::test {

namespace {

using PosePathTest = TemporaryFolder;

glm::dquat turn_about_y(double degrees) {
    return glm::angleAxis(glm::radians(degrees), glm::dvec3(0, 1, 0));
}

double angle_between_deg(const glm::dquat& a, const glm::dquat& b) {
    return glm::degrees(2 * std::acos(std::min(1.0, std::abs(glm::dot(a, b)))));
}

}  // namespace

TEST_F(PosePathTest, LinearInPositionConstantSpeedInAngle) {
    const PosePath path({{1, {{0, 0, 0}, turn_about_y(0)}}, {3, {{4, 2, -6}, turn_about_y(120)}}}, "test");
    const Pose quarter = path.at(1.5);
    EXPECT_NEAR(glm::length(quarter.position_m - glm::dvec3(1, 0.5, -1.5)), 0, 1e-12);
    EXPECT_NEAR(angle_between_deg(quarter.orientation, turn_about_y(30)), 0, 1e-6);
    EXPECT_NEAR(glm::length(quarter.orientation), 1, 1e-12);
    EXPECT_EQ(path.duration_s(), 3);
}

TEST_F(PosePathTest, TakesTheShortWayBetweenOppositeQuaternions) {
    const PosePath path({{0, {{}, turn_about_y(10)}}, {1, {{}, -turn_about_y(50)}}}, "test");
    EXPECT_NEAR(angle_between_deg(path.at(0.5).orientation, turn_about_y(30)), 0, 1e-6);
}

TEST_F(PosePathTest, HeldBeforeAndAfter) {
    const PosePath path({{1, {{1, 0, 0}, turn_about_y(5)}}, {2, {{2, 0, 0}, turn_about_y(6)}}}, "test");
    EXPECT_EQ(path.at(-5).position_m.x, 1);
    EXPECT_EQ(path.at(1).position_m.x, 1);
    EXPECT_EQ(path.at(2).position_m.x, 2);
    EXPECT_EQ(path.at(99).position_m.x, 2);
}

TEST_F(PosePathTest, RefusesBadKeys) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    expect_contains(input_error([&] { PosePath({{0, {{nan, 0, 0}}}}, "here"); }), "here, key 1");
    expect_contains(input_error([&] { PosePath({{0, {}}, {0, {}}}, "here"); }), "here, key 2");
    expect_contains(input_error([&] { PosePath({{0, {{}, glm::dquat(2, 0, 0, 0)}}}, "here"); }), "unit quaternion");
}

TEST_F(PosePathTest, CsvRoundTripIsExact) {
    const PosePath path({{0, {{0.1, 1.6, -1e-9}, turn_about_y(33)}}, {1.0 / 30, {{0.2, 1.6, 3}, turn_about_y(200)}}},
                        "test");
    const std::filesystem::path file = folder_ / "path.csv";
    write_path_csv(file, path);
    const PosePath again = read_path_csv(file);
    ASSERT_EQ(again.keys().size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(again.keys()[i].time_s, path.keys()[i].time_s);
        EXPECT_EQ(again.keys()[i].pose.position_m, path.keys()[i].pose.position_m);
        EXPECT_LT(angle_between_deg(again.keys()[i].pose.orientation, path.keys()[i].pose.orientation), 1e-6);
    }
}

TEST_F(PosePathTest, CsvAcceptsHeaderCommentsAndWindowsLines) {
    const PosePath path = read_path_csv(
        write("path.csv", "# recorded\r\ntime_s,x,y,z,qw,qx,qy,qz\r\n\r\n0, 1,2,3, 1,0,0,0\r\n+1,4,5,6,0,1,0,0"));
    ASSERT_EQ(path.keys().size(), 2u);
    EXPECT_EQ(path.keys()[1].pose.position_m, glm::dvec3(4, 5, 6));
    EXPECT_EQ(path.keys()[1].pose.orientation.x, 1);
}

TEST_F(PosePathTest, CsvErrorsNameTheLine) {
    const auto error = [this](const std::string& text) {
        const std::filesystem::path file = write("bad.csv", text);
        return input_error([&] { read_path_csv(file); });
    };
    const std::string good = "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n";
    expect_contains(error(good + "1,0,nan,0,1,0,0,0\n"), "bad.csv:3: expected a finite number as y, found \"nan\"");
    expect_contains(error("nan,0,0,0,1,0,0,0\n"), "bad.csv:1: expected a finite number as time_s");
    expect_contains(error(good + "\n1,0,north,0,1,0,0,0\n"),
                    "bad.csv:4: expected a finite number as y, found \"north\"");
    expect_contains(error(good + "1,0,1e999,0,1,0,0,0\n"), "bad.csv:3");
    expect_contains(error(good + "1,0,0,-1.1e9,1,0,0,0\n"),
                    "bad.csv:3: expected metres from -1e9 to 1e9 as z, found \"-1.1e9\"");
    EXPECT_NO_THROW(read_path_csv(write("far.csv", good + "1,1e9,0,-1e9,1,0,0,0\n")));
    expect_contains(error(good + "1,0,0\n"), "bad.csv:3: expected 8 columns");
    expect_contains(error(good + "1,0,0,0,1,0,0,0,\n"), "found 9");
    EXPECT_TRUE(error("t;x;y;z;qw;qx;qy;qz\n0;0;1,6;0;1;0;0;0\n")
                    .ends_with("bad.csv:2: expected 8 columns separated by commas, with decimal points "
                               "(time_s, x, y, z, qw, qx, qy, qz), found 2"));
    expect_contains(error(good + "0,0,0,0,1,0,0,0\n"), "bad.csv:3: expected a time after");
    expect_contains(error(good + "1,0,0,0,0,0,0,0\n"), "bad.csv:3");
    expect_contains(error(good + "1,0,0,0,0,0,0,0\n"), "unit quaternion");
    expect_contains(error("t,x,y,z,qw,qx,qy,qz\n"), "at least one key");
    expect_contains(error(""), "at least one key");
    expect_contains(input_error([&] { read_path_csv(folder_ / "none.csv"); }), "no such file");
}

TEST_F(PosePathTest, EpochSecondsCountFromTheFirstSample) {
    const PosePath path =
        read_path_csv(write("epoch.csv", "1763958000.25,0,0,0,1,0,0,0\n1763958002.25,4,0,0,1,0,0,0\n"));
    EXPECT_EQ(path.clock_start_s(), 1763958000.25);
    EXPECT_EQ(path.duration_s(), 2);
    EXPECT_EQ(path.at(1).position_m.x, 2);
    EXPECT_EQ(clock_note(path, "epoch.csv"),
              "epoch.csv begins at 1763958000.25 s; its times count from its first sample");
    const PosePath before = read_path_csv(write("before.csv", "-3,0,0,0,1,0,0,0\n-1,4,0,0,1,0,0,0\n"));
    EXPECT_EQ(before.duration_s(), 2) << "no frame is before time 0";
    const PosePath own = read_path_csv(write("own.csv", "-1,0,0,0,1,0,0,0\n3,4,0,0,1,0,0,0\n"));
    EXPECT_EQ(own.duration_s(), 3);
    EXPECT_EQ(clock_note(own, "own.csv"), "");
}

TEST_F(PosePathTest, RefusesUnitsThatAreNotSeconds) {
    const auto error = [this](const std::string& first, const std::string& last) {
        const std::string rest = ",0,0,0,1,0,0,0\n";
        const std::filesystem::path file = write("unit.csv", first + rest + last + rest);
        return input_error([&] { read_path_csv(file); });
    };
    const std::string expected = "unit.csv: expected times in seconds that span a day (86400 s) at most, found ";
    expect_contains(error("1763958000000000000", "1763958002000000000"), expected + "1.763958002e+18: millisec");
    expect_contains(error("1763958000000", "1763958002000"), expected + "1763958002000: millisec");
    expect_contains(error("0", "2000000000"), expected + "times from 0 to 2000000000");
    expect_contains(error("-9e300", "0"), expected);
}

TEST(PosePath, AnotherPathHasAnotherFingerprint) {
    const std::vector<PosePath::Key> keys{{0, {{1, 2, 3}, {1, 0, 0, 0}}}, {1, {{1, 2, 4}, {1, 0, 0, 0}}}};
    const std::string whole = path_fingerprint(PosePath(keys, "test"));
    EXPECT_EQ(whole.size(), 16u);
    EXPECT_EQ(whole, path_fingerprint(PosePath(keys, "again")));
    for (const auto change :
         {+[](PosePath::Key& key) { key.time_s += 1e-9; }, +[](PosePath::Key& key) { key.pose.position_m.z += 1e-9; },
          +[](PosePath::Key& key) {
              key.pose.orientation = {0, 0, 1, 0};
          }}) {
        std::vector<PosePath::Key> changed = keys;
        change(changed[1]);
        EXPECT_NE(whole, path_fingerprint(PosePath(changed, "test")));
    }
    EXPECT_NE(whole, path_fingerprint(PosePath({keys[0]}, "test")));
}

}  // namespace equistream::test
