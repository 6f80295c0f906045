/// How often play loads the scene's geometry (RayDepth and RayColour are the test's own here, and count), and which of
/// a stream's data its eyes keep.
#include <tests/unit/client/fill_scene.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <programs/play/frame_player.h>
#include <programs/play/view_writer.h>

#include <client/depth/ray_colour.h>
#include <client/depth/ray_depth.h>

#include <algorithm>
#include <utility>

namespace equistream {
namespace {

struct Loads {
    int of_depth = 0, of_colours = 0;
} loads;

}  // namespace

struct RayDepth::State {};

RayDepth::RayDepth(const SceneDescription&) {
    ++loads.of_depth;
}
RayDepth::~RayDepth() = default;
void RayDepth::set_time(double) {}
void RayDepth::cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) {
    test::AnalyticDepth(test::ball_and_wall).cast(camera, pose, depth_m);
}
bool RayDepth::cast_patches(const PatchAtlas&, const Pose&, ImageView<float>) {
    return false;
}

/// As ray_colour.h says: loaded by the first cast, if not before that.
struct RayColour::State {
    bool is_loaded = false;

    void load() { loads.of_colours += !std::exchange(is_loaded, true); }
};

RayColour::RayColour(const SceneDescription&) : state_(std::make_unique<State>()) {}
RayColour::~RayColour() = default;
void RayColour::start_loading() {
    state_->load();
}
void RayColour::set_time(double) {}
void RayColour::cast(std::span<const GeometryRay> rays, std::span<GeometryHit> hits) {
    state_->load();
    std::ranges::transform(rays, hits.begin(), [](const GeometryRay& ray) {
        const glm::dvec3 origin_m(ray.origin_m), direction(ray.direction);
        const double distance_m = test::ball_and_wall(origin_m, direction);
        return GeometryHit{.distance_m = float(distance_m),
                           .base_colour = glm::vec3(0.5f),
                           .normal = -ray.direction,
                           .instance = distance_m < test::wall_alone(origin_m, direction) ? 1u : 2u};
    });
}

namespace play {
namespace {

class GeometryLoads : public test::TemporaryFolder {
protected:
    GeometryLoads() {
        loads = {};
        write("room.glb", "a model that only a real ray cast would read");
        settings.scene = write(
            "room.json", R"({"model": "room.glb", "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]}})");
        settings.source = "frames of the test's own";
        settings.size = cli::Size{320, 200};
    }

    static ReceivedPicture picture(const PerspectiveCamera& camera, Eye eye, std::int64_t index, const Pose& head) {
        ReceivedPicture picture;
        picture.info.index = index;
        picture.info.time_s = double(index) / 30;
        picture.info.head = head;
        picture.info.camera = camera;
        picture.info.eye = eye;
        picture.info.lock = AxisLock::path;
        picture.info.scene = "room";
        picture.info.camera_pose = camera_pose(camera, picture.info.head, eye, picture.info.ipd_m, picture.info.lock);
        picture.rgb = test::render(test::ball_and_wall, test::red_and_smooth, camera, picture.info.camera_pose).rgb;
        return picture;
    }
    static ReceivedFrame frame(std::int64_t index, const Pose& head = {}) {
        ReceivedFrame frame;
        frame.main = picture({400, 250, 2 * std::atan(1.25)}, Eye::left, index, head);
        frame.small = picture({80, 50, pi / 2}, Eye::right, index, head);
        return frame;
    }
    static std::int64_t filled(const PlayedFrame& played, std::string_view fill_pass) {
        const auto& counts = played.figures.right.filled;
        const auto found = std::ranges::find(counts, fill_pass, [](const auto& count) { return count.first; });
        return found == counts.end() ? 0 : found->second;
    }

    Settings settings;
    Report report;
};

/// As if frames took too long until another way is taken.
void slow_down(FramePlayer& player, PlayedFrame played, Report& report) {
    played.times = {{2e6, 1}};
    for (std::size_t i = 0; i < RechooseOptions{}.window; ++i)
        player.rechoose(played, 2, report);
}

TEST_F(GeometryLoads, AllChainsShareWhatWasLoadedOnce) {
    settings.method = "auto";
    settings.budget_ms = 1e6;
    settings.fill = "geometry,small,small-wide,pushpull";
    FramePlayer player(settings);
    const ReceivedFrame first = frame(0), second = frame(1);
    player.prepare(first, report);
    player.settle(first, &second, report);
    std::vector<std::string> chains{report.fill};
    PlayedFrame played;
    player.play(second, played);
    EXPECT_GT(filled(played, "geometry"), 0);
    for (int change = 0; change < 2; ++change) {
        slow_down(player, played, report);
        ASSERT_FALSE(report.changes.empty());
        chains.push_back(report.changes.back().to.fill);
        player.play(second, played);
        EXPECT_GT(filled(played, "geometry"), 0) << report.changes.back().line();
    }
    EXPECT_EQ(chains, (std::vector<std::string>{settings.fill, "geometry,small-wide,pushpull", "geometry,pushpull"}));
    EXPECT_EQ(loads.of_colours, 1);
    EXPECT_EQ(loads.of_depth, 1);
}

TEST_F(GeometryLoads, WhereNoPassTakesColoursFromItOnlyDepthIsLoaded) {
    settings.fill = "small,pushpull";
    FramePlayer player(settings);
    const ReceivedFrame only = frame(0);
    player.prepare(only, report);
    player.settle(only, nullptr, report);
    PlayedFrame played;
    player.play(only, played);
    EXPECT_GT(filled(played, "small"), 0);
    EXPECT_EQ(loads.of_colours, 0);
    EXPECT_EQ(loads.of_depth, 1);
}

TEST_F(GeometryLoads, WaysAreTriedWithWhatTheFrameBeforeShows) {
    settings.method = "auto";
    settings.budget_ms = 1e6;
    settings.fill = "earlier,pushpull";
    FramePlayer player(settings);
    const ReceivedFrame first = frame(0, {.position_m = {0.15, 0, 0}}), second = frame(1);
    player.prepare(first, report);
    player.settle(first, &second, report);
    ASSERT_TRUE(report.choice);
    const FilledCounts tried = report.choice->tried[report.choice->chosen].trial.filled;
    ASSERT_EQ(report.choice->plan().fill, settings.fill);
    const auto by_earlier = std::ranges::find(tried, "earlier", &FilledCounts::value_type::first);
    ASSERT_NE(by_earlier, tried.end());
    EXPECT_GT(by_earlier->second, 100);
}

/// A frame as a stream with a depth track and with motion gives it.
ReceivedFrame streamed_frame(std::int64_t index) {
    ReceivedFrame frame;
    frame.main.info.index = index;
    frame.main.info.camera = EquirectCamera{256, 128, {}};
    frame.main.info.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 0.5, false}, 0, false};
    frame.main.info.crf = 30;
    frame.main.info.visible_loss = VisibleLoss{{1, 2, 3, 4, 5, 6, 7, 8}};
    frame.main.info.moving = {{{}, 1, 2, {{100, 200, 250}}}};
    auto rendered = test::render(test::ball_and_wall, test::red_and_smooth, frame.main.info.camera, {});
    frame.main.rgb = std::move(rendered.rgb);
    frame.main.depth_m = std::move(rendered.depth_m);
    return frame;
}

using Eyes = test::TemporaryFolder;

TEST_F(Eyes, VideosOfAStreamWithDepthAndMotionCanBeRead) {
    Settings settings;
    settings.source = "a stream of the test's own";
    settings.depth = "stream";
    settings.method = "mesh";
    settings.fill = "pushpull";
    settings.size = cli::Size{96, 64};
    settings.format = Format::mp4;
    settings.out = folder_;
    FramePlayer player(settings);
    Report report;
    player.prepare(streamed_frame(0), report);
    EyesWriter eyes(settings);
    for (std::int64_t index = 0; index < 2; ++index) {
        PlayedFrame played;
        player.play(streamed_frame(index), played);
        eyes.write({played.left.picture, {}, played.left.info}, {played.right.picture, {}, played.right.info});
    }
    eyes.finish();
    StreamReader reader((folder_ / "right.mp4").string());
    for (std::int64_t index = 0; index < 2; ++index) {
        const auto picture = reader.next();
        ASSERT_TRUE(picture && picture->info) << reader.truncation();
        EXPECT_EQ(picture->info->index, index);
        EXPECT_EQ(picture->info->eye, Eye::right);
        EXPECT_FALSE(picture->info->depth_code);
        EXPECT_FALSE(picture->info->visible_loss) << "the stream's, not this video's";
        EXPECT_TRUE(picture->info->moving.empty()) << "regions of the sphere, not of this view";
    }
    EXPECT_EQ(reader.truncation(), "");
}

/// It is only turned, which takes less time.
TEST_F(Eyes, AFrameWhoseDepthIsLostSaysNothingOfHowLongOthersTake) {
    Settings settings;
    settings.source = "a stream of the test's own";
    settings.method = "auto";
    settings.budget_ms = 1e6;
    settings.fill = "pushpull";
    settings.size = cli::Size{96, 64};
    FramePlayer player(settings);
    Report report;
    const ReceivedFrame first = streamed_frame(0), second = streamed_frame(1);
    ReceivedFrame lost = streamed_frame(2);
    lost.main.depth_m = {};
    player.prepare(first, report);
    player.settle(first, &second, report);
    ASSERT_EQ(report.method, "mesh");
    PlayedFrame played;
    player.play(lost, played);
    EXPECT_TRUE(played.figures.lacks_depth);
    slow_down(player, played, report);
    EXPECT_TRUE(report.changes.empty());
    player.play(second, played);
    EXPECT_FALSE(played.figures.lacks_depth);
    slow_down(player, played, report);
    EXPECT_FALSE(report.changes.empty());
}

}  // namespace
}  // namespace play
}  // namespace equistream
