/// Streams as a client meets them: to their very last frame, and with tracks that are not ours or not of one recording.
#include <client/receive/receive.h>
#include <client/warp/engine.h>
#include <equistream/error.h>
#include <equistream/stream.h>
#include <equistream/window.h>

#include <gtest/gtest.h>

#include <client/receive/decoded_pictures.h>
#include <client/receive/feeds.h>
#include <client/receive/foreign_numbers.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t first_index = 5, frame_count = 9;

FrameInfo info(std::int64_t index, int width, int height) {
    FrameInfo info;
    info.index = index;
    info.time_s = double(index) / 30;
    info.camera = EquirectCamera{width, height, {}};
    info.scene = "test";
    return info;
}

/// Another grey for each frame, to tell them apart after coding; a small one is brighter by 20.
std::uint8_t main_grey(std::int64_t index) {
    return std::uint8_t(40 + 15 * (index - first_index));
}

class StreamFeeds : public testing::Test {
protected:
    void SetUp() override { fs::create_directories(folder_); }
    void TearDown() override { fs::remove_all(folder_); }

    fs::path write(const std::string& name, bool length_is_known) const {
        const fs::path file = folder_ / name;
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.gop = 4;
        settings.tracks = {{TrackRole::main, 128, 64}, {TrackRole::small, 64, 64}};
        settings.pictures = length_is_known ? std::uint32_t(frame_count) : 0;
        StreamWriter writer(file.string(), settings);
        for (std::int64_t index = first_index; index < first_index + frame_count; ++index) {
            const std::uint8_t grey = main_grey(index);
            writer.write(TrackRole::main, ByteImage(128, 64, 3, grey).view(), info(index, 128, 64));
            writer.write(TrackRole::small, ByteImage(64, 64, 3, std::uint8_t(grey + 20)).view(), info(index, 64, 64));
        }
        writer.finish();
        return file;
    }

    /// Makes our frame data of some tracks unknown to us: the video is somebody else's then. `first` and `last` count
    /// the track's pictures in coded order.
    static void disown(const fs::path& file, std::initializer_list<TrackRole> tracks, std::int64_t first = 0,
                       std::int64_t last = frame_count - 1) {
        std::ifstream in(file, std::ios::binary);
        std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
        int disowned = 0;
        for (const TrackRole role : tracks) {
            // UUID, version and size, then the role; written beside one another, so their bytes stand together.
            const auto payload = encode_frame_info(role, info(0, 2, 2));
            const auto uuid_end = payload.begin() + 16;
            std::int64_t picture = -1;
            for (auto at = bytes.begin();; ++at) {
                at = std::search(at, bytes.end(), payload.begin(), uuid_end,
                                 [](char byte, std::uint8_t of_ours) { return std::uint8_t(byte) == of_ours; });
                if (at == bytes.end())
                    break;
                if (std::uint8_t(at[20]) != payload[20] || ++picture < first || picture > last)
                    continue;
                *at ^= 0x55;
                ++disowned;
            }
        }
        EXPECT_EQ(disowned, (last - first + 1) * std::int64_t(tracks.size()));
        std::ofstream(file, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
    }

    fs::path folder_ = fs::temp_directory_path() / ("equistream_stream_feeds_" + std::to_string(::getpid()));
};

TEST_F(StreamFeeds, TheLastFrameComesWithItsSmallPictureToo) {
    for (const char* name : {"a.mkv", "a.mp4", "a.ts"})
        for (const bool length_is_known : {true, false}) {
            SCOPED_TRACE(std::string(name) + (length_is_known ? "" : ", length not known"));
            const auto feed = open_feed(write(name, length_is_known).string());
            std::int64_t expected = first_index;
            while (const auto frame = feed->next()) {
                EXPECT_EQ(frame->main.info.index, expected);
                EXPECT_NEAR(frame->main.rgb.pixel(64, 32)[1], main_grey(expected), 3);
                ASSERT_TRUE(frame->small);
                EXPECT_EQ(frame->small->info.index, expected);
                EXPECT_NEAR(frame->small->rgb.pixel(32, 32)[1], main_grey(expected) + 20, 3);
                ++expected;
            }
            EXPECT_EQ(expected, first_index + frame_count);
            EXPECT_EQ(feed->truncation(), "");
            EXPECT_FALSE(feed->next()) << "after the end";
        }
}

TEST_F(StreamFeeds, TheLastFrameAloneCanBeAskedFor) {
    constexpr std::int64_t last = first_index + frame_count - 1;
    const auto feed = open_feed(write("a.mkv", true).string(), {.first_frame = last, .last_frame = last});
    const auto frame = feed->next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->main.info.index, last);
    EXPECT_TRUE(frame->small);
    EXPECT_FALSE(feed->next());
    EXPECT_EQ(feed->truncation(), "");
}

TEST_F(StreamFeeds, JumpsBringWholeFrames) {
    for (const char* name : {"a.mkv", "a.mp4", "a.ts"}) {
        const auto feed = open_feed(write(name, true).string());
        EXPECT_FALSE(feed->is_live());
        ASSERT_TRUE(feed->next());
        for (const std::int64_t wanted : {11, 6, 13, 5, 9}) {
            SCOPED_TRACE(std::string(name) + " to " + std::to_string(wanted));
            ASSERT_TRUE(feed->seek(wanted));
            std::int64_t expected = wanted;
            while (const auto frame = feed->next()) {
                EXPECT_EQ(frame->main.info.index, expected);
                EXPECT_NEAR(frame->main.rgb.pixel(64, 32)[1], main_grey(expected), 3);
                ASSERT_TRUE(frame->small);
                EXPECT_EQ(frame->small->info.index, expected);
                ++expected;
            }
            EXPECT_EQ(expected, first_index + frame_count);
            EXPECT_EQ(feed->truncation(), "");
        }
        ASSERT_TRUE(feed->seek(first_index + frame_count));
        EXPECT_FALSE(feed->next());
    }
}

/// Frames of foreign video are numbered as they are shown, wherever one jumps to.
TEST_F(StreamFeeds, JumpsInForeignVideoCountOn) {
    const fs::path file = write("a.mkv", true);
    disown(file, {TrackRole::main, TrackRole::small});
    const auto feed = open_feed(file.string());
    ASSERT_EQ(feed->next()->main.info.index, 0);
    for (const std::int64_t wanted : {6, 2, 0, 8}) {
        ASSERT_TRUE(feed->seek(wanted));
        for (std::int64_t expected = wanted; expected < frame_count; ++expected) {
            const auto frame = feed->next();
            ASSERT_TRUE(frame) << wanted;
            EXPECT_EQ(frame->main.info.index, expected);
            EXPECT_NEAR(frame->main.info.time_s, double(expected) / 30, 1e-6);
            EXPECT_NEAR(frame->main.rgb.pixel(64, 32)[1], main_grey(first_index + expected), 4);
        }
        EXPECT_FALSE(feed->next());
        EXPECT_EQ(feed->truncation(), "");
    }
}

TEST(ForeignNumbers, CountFramesHoweverTheirTimesAreRounded) {
    ForeignNumbers numbers;
    for (std::int64_t i = 0; i < 1000; ++i) {
        const auto [number, time_s] = numbers.next(1e-3 * std::round(1e3 * double(i) / 60), 60);
        ASSERT_EQ(number, i);
        ASSERT_EQ(time_s, double(i) / 60);
    }
    EXPECT_EQ(numbers.next({}, 60).first, 1000);
}

/// The rate that a container says may be no more than a mean.
TEST(ForeignNumbers, TimesAreTheContainersWhateverTheRate) {
    for (const double frames_per_second : {60.0, 6.5}) {
        ForeignNumbers numbers;
        std::int64_t before = -1;
        for (int i = 0; i < 70; ++i) {
            const double shown_s = i < 60 ? i / 60.0 : i - 59.0;
            const auto [number, time_s] = numbers.next(shown_s, frames_per_second);
            ASSERT_GT(number, before);
            ASSERT_NEAR(time_s, shown_s, container_rounding_s);
            before = number;
        }
        numbers.jump(0.5);
        EXPECT_TRUE(numbers.is_before_jump(29 / 60.0, frames_per_second));
        EXPECT_FALSE(numbers.is_before_jump(0.499, frames_per_second)) << "rounded";
        EXPECT_NEAR(numbers.next(0.5, frames_per_second).second, 0.5, container_rounding_s);
    }
}

/// That of a file which a server sends over and over.
TEST(ForeignNumbers, GoOnWhereTheClockBeginsAgain) {
    ForeignNumbers numbers;
    for (std::int64_t i = 0; i < 270; ++i) {
        const auto [number, time_s] = numbers.next(double(i % 90) / 30, 30);
        ASSERT_EQ(number, i);
        ASSERT_NEAR(time_s, double(i) / 30, 1e-9);
    }
    numbers.jump(1);
    EXPECT_NEAR(numbers.next(1.0, 30).second, 1, 1e-9) << "by the clock as it is there";
}

TEST_F(StreamFeeds, ForeignVideoOfVariableFrameRateKeepsItsPace) {
    const std::vector<std::int64_t> shown = {0, 1, 2, 3, 4, 5, 65, 125, 185};
    const auto grey = [&](std::size_t i) { return std::uint8_t(40 + 20 * i); };
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.frames_per_second = 60;
    settings.tagged = false;
    settings.tracks = {{TrackRole::main, 128, 64}};
    const fs::path file = folder_ / "variable.mkv";
    StreamWriter writer(file.string(), settings);
    for (std::size_t i = 0; i < shown.size(); ++i)
        writer.write(TrackRole::main, ByteImage(128, 64, 3, grey(i)).view(), info(shown[i], 128, 64));
    writer.finish();
    const auto feed = open_feed(file.string());
    const auto expect_from = [&](std::size_t first) {
        for (std::size_t i = first; i < shown.size(); ++i) {
            const auto frame = feed->next();
            ASSERT_TRUE(frame) << i;
            EXPECT_EQ(frame->main.info.index, shown[i]);
            EXPECT_NEAR(frame->main.info.time_s, double(shown[i]) / 60, 1e-6);
            EXPECT_NEAR(frame->main.rgb.pixel(64, 32)[1], grey(i), 4);
        }
        EXPECT_FALSE(feed->next());
    };
    expect_from(0);
    for (const auto& [wanted, first] : {std::pair{65, 6}, {66, 7}, {3, 3}, {185, 8}}) {
        SCOPED_TRACE(wanted);
        ASSERT_TRUE(feed->seek(wanted));
        expect_from(std::size_t(first));
    }
}

/// Tracks lie side by side, and a few frames are held however little may be.
TEST_F(StreamFeeds, DepthComesWithEveryFrameOfALongGroup) {
    constexpr std::int64_t group = 90, frames = 2 * group;
    for (const char* name : {"long.mp4", "long.mkv"}) {
        const fs::path file = folder_ / name;
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.gop = int(group);
        settings.frames_per_second = 90;
        settings.pictures = std::uint32_t(frames);
        settings.tracks = {{TrackRole::main, 128, 64}, {TrackRole::depth, 128, 64, DepthCodeId::w10}};
        StreamWriter writer(file.string(), settings);
        for (std::int64_t index = 0; index < frames; ++index) {
            FrameInfo with_code = info(index, 128, 64);
            with_code.frames_per_second = 90;
            with_code.time_s = double(index) / 90;
            writer.write(TrackRole::main, ByteImage(128, 64, 3, 99).view(), with_code);
            with_code.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 1, true}, 0};
            writer.write_depth(TrackRole::depth, FloatImage(128, 64, 1, 2.0f).view(), with_code);
        }
        writer.finish();
        for (const std::size_t max_held_bytes : {std::size_t{512} << 20, std::size_t{1}}) {
            SCOPED_TRACE(std::string(name) + ", " + std::to_string(max_held_bytes) + " bytes");
            const auto feed = open_stream_feed(file.string(), {.depth = true}, max_held_bytes);
            std::int64_t with_depth = 0;
            while (const auto frame = feed->next())
                with_depth += !frame->main.depth_m.empty();
            EXPECT_EQ(with_depth, frames);
        }
    }
}

TEST_F(StreamFeeds, PatchesAreOfMainsSphere) {
    for (const int sphere_width : {128, 16384}) {
        SCOPED_TRACE(sphere_width);
        const fs::path file = folder_ / "patches.mkv";
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.tracks = {{TrackRole::main, 128, 64}, {TrackRole::patches, 64, 64}};
        StreamWriter writer(file.string(), settings);
        writer.write(TrackRole::main, ByteImage(128, 64, 3, 99).view(), info(first_index, 128, 64));
        FrameInfo atlas = info(first_index, sphere_width, sphere_width / 2);
        atlas.patches.emplace();
        atlas.patches->sphere_width = sphere_width;
        atlas.patches->sphere_height = sphere_width / 2;
        atlas.patches->offsets_m = {{0.02, 0, 0}};
        atlas.patches->columns = atlas.patches->rows = 4;
        atlas.patches->slots.assign(16, {0, 3, 2, true});
        writer.write(TrackRole::patches, ByteImage(64, 64, 3, 99).view(), atlas);
        writer.finish();
        const auto feed = open_feed(file.string());
        if (sphere_width == 128) {
            EXPECT_TRUE(feed->next()->patches);
            continue;
        }
        try {
            feed->next();
            ADD_FAILURE() << "would be looked up in a sphere of a size that no picture has";
        } catch (const WorkError& error) {
            EXPECT_EQ(std::string(error.what()), file.string() + ": frame " + std::to_string(first_index) +
                                                     " of patches: expected the sphere of its main picture, 128x64, "
                                                     "found 16384x8192");
        }
    }
}

TEST(TaggedSizes, WhatIsNoAtlasHasNoTableOfPatches) {
    const auto picture = [](int width) {
        ReceivedPicture made;
        made.info = info(first_index, 128, 64);
        made.rgb = ByteImage(width, 64, 3);
        made.depth_m = FloatImage(width, 64, 1);
        return made;
    };
    const auto refused = [](const ReceivedFrame& frame) {
        try {
            require_tagged_sizes(frame);
            return std::string("nothing");
        } catch (const WorkError& error) {
            return std::string(error.what());
        }
    };
    ReceivedFrame frame;
    frame.main = picture(128);
    frame.depth_views = {picture(128)};
    frame.depth_views.front().rgb = {};
    EXPECT_EQ(refused(frame), "nothing");
    // A picture of 64x64 may be an atlas of a sphere of any size, and a main picture is looked up in that sphere.
    PatchAtlas atlas;
    atlas.sphere_width = 128;
    atlas.sphere_height = 64;
    atlas.columns = atlas.rows = 4;
    for (ReceivedPicture* wrong : {&frame.main, &frame.depth_views.front()}) {
        wrong->info.patches = atlas;
        EXPECT_NE(refused(frame).find("expected a whole picture, found a table of patches"), std::string::npos);
        wrong->info.patches.reset();
    }
    frame.depth_views.front().depth_m = FloatImage(64, 64, 1);
    EXPECT_NE(refused(frame).find("a view's depth: expected depth of 128x64, as it is tagged, found 64x64"),
              std::string::npos);
}

/// A window of 128x64 pixels of a sphere of 512x256, ever farther to the right, within a base of 128x64; the frame in
/// the middle has none.
class StreamedWindows : public StreamFeeds {
protected:
    static constexpr std::int64_t frames = 5;

    void SetUp() override {
        StreamFeeds::SetUp();
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.tracks = {{TrackRole::main, 128, 64},
                           {TrackRole::window, 128, 64},
                           {TrackRole::window_depth, 128, 64, DepthCodeId::w10},
                           {TrackRole::window_reflections, 128, 64, DepthCodeId::w10}};
        StreamWriter writer(file_.string(), settings);
        for (std::int64_t i = 0; i < frames; ++i) {
            FrameInfo base = info(first_index + i, 128, 64);
            writer.write(TrackRole::main, ByteImage(128, 64, 3, 50).view(), base);
            if (i == frames / 2)
                continue;
            FrameInfo window = base;
            window.camera = window_camera(grid, place(i));
            if (i == frames - 1)
                window.camera_pose.position_m = moved_m_;
            writer.write(TrackRole::window, ByteImage(128, 64, 3, 150).view(), window);
            window.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 1, true}, 0};
            writer.write_depth(TrackRole::window_depth, FloatImage(128, 64, 1, 3).view(), window);
            writer.write_depth(TrackRole::window_reflections, FloatImage(128, 64, 1, 5).view(), window);
        }
        writer.finish();
    }
    static WindowPlace place(std::int64_t i) { return {int(448 + 16 * i) % grid.columns, 96}; }

    static constexpr WindowGrid grid{512, 256, 128, 64};
    fs::path file_ = folder_ / "window.mkv";
    glm::dvec3 moved_m_{0};
};

TEST_F(StreamedWindows, EyesLookThroughTheWindowWhereOneCame) {
    const auto feed = open_feed(file_.string(), {.depth = true, .specular = true});
    for (std::int64_t i = 0; i < frames; ++i) {
        SCOPED_TRACE(i);
        const auto frame = feed->next();
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->main.info.index, first_index + i);
        const bool has_window = i != frames / 2;
        ASSERT_EQ(frame->base.has_value(), has_window);
        EXPECT_NEAR(*frame->main.rgb.pixel(64, 32), has_window ? 150 : 50, 2);
        if (!has_window)
            continue;
        EXPECT_TRUE(same_camera(frame->main.info.camera, window_camera(grid, place(i))));
        EXPECT_NEAR(*frame->main.depth_m.pixel(64, 32), 3, 0.05);
        EXPECT_NEAR(*frame->main.virtual_depth_m.pixel(64, 32), 5, 0.1);
        EXPECT_NEAR(*frame->base->rgb.pixel(64, 32), 50, 2);
        EXPECT_TRUE(frame->base->depth_m.empty());
        EXPECT_TRUE(same_camera(frame->base->info.camera, EquirectCamera{128, 64, {}}));
    }
    EXPECT_FALSE(feed->next());
}

class StreamedWindowElsewhere : public StreamedWindows {
protected:
    StreamedWindowElsewhere() { moved_m_ = {0, 0.1, 0}; }
};

TEST_F(StreamedWindowElsewhere, IsRefused) {
    const auto feed = open_feed(file_.string());
    for (std::int64_t i = 0; i + 1 < frames; ++i)
        ASSERT_TRUE(feed->next());
    try {
        feed->next();
        ADD_FAILURE() << "a window is a part of its sphere";
    } catch (const WorkError& error) {
        EXPECT_EQ(std::string(error.what()), file_.string() + ": frame " + std::to_string(first_index + frames - 1) +
                                                 " of window: expected the position and the axes of the sphere around "
                                                 "it, found others");
    }
}

TEST_F(StreamFeeds, NoJumpsWhileAThreadReadsAhead) {
    const auto feed = open_feed(write("a.mkv", true).string(), {.frames_ahead = 2});
    ASSERT_TRUE(feed->next());
    EXPECT_FALSE(feed->seek(7));
}

TEST_F(StreamFeeds, MirrorsComeWithTheMainPictureWhereAskedFor) {
    const fs::path file = folder_ / "mirrors.mkv";
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 128, 64}, {TrackRole::reflections, 128, 64, DepthCodeId::w10}};
    FloatImage image_m(128, 64, 1, std::nanf(""));
    for (int y = 0; y < 64; ++y)
        std::fill_n(image_m.pixel(0, y), 64, 2.0f);
    StreamWriter writer(file.string(), settings);
    for (std::int64_t index = first_index; index < first_index + 2; ++index) {
        FrameInfo with_code = info(index, 128, 64);
        writer.write(TrackRole::main, ByteImage(128, 64, 3, 99).view(), with_code);
        with_code.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 1, true}, 0};
        writer.write_depth(TrackRole::reflections, image_m.view(), with_code);
    }
    writer.finish();
    for (const bool depth : {false, true})
        for (const bool specular : {false, true}) {
            SCOPED_TRACE(std::to_string(depth) + std::to_string(specular));
            const auto feed = open_feed(file.string(), {.depth = depth, .specular = specular});
            int frames = 0;
            while (const auto frame = feed->next()) {
                ++frames;
                ASSERT_EQ(frame->main.specular.empty(), !specular);
                ASSERT_EQ(frame->main.virtual_depth_m.empty(), !specular);
                if (!specular)
                    continue;
                EXPECT_EQ(*frame->main.specular.pixel(20, 30), 1);
                EXPECT_NEAR(*frame->main.virtual_depth_m.pixel(20, 30), 2, 0.02);
                EXPECT_EQ(*frame->main.specular.pixel(100, 30), 0);
            }
            EXPECT_EQ(frames, 2);
        }
}

TEST_F(StreamFeeds, ASecondTrackOfSomebodyElsesVideoIsNoSecondEye) {
    const fs::path file = write("a.mkv", true);
    disown(file, {TrackRole::main, TrackRole::small});
    const auto feed = open_feed(file.string());
    std::int64_t expected = 0;
    while (const auto frame = feed->next()) {
        EXPECT_FALSE(frame->posed);
        EXPECT_FALSE(frame->small);
        EXPECT_EQ(frame->main.info.index, expected) << "pictures are numbered as they come";
        EXPECT_EQ(frame->main.rgb.width(), 128);
        EXPECT_NEAR(frame->main.rgb.pixel(64, 32)[1], main_grey(first_index + expected), 3);
        ++expected;
    }
    EXPECT_EQ(expected, frame_count);
}

TEST_F(StreamFeeds, TracksThatDoNotBelongTogetherAreNotPaired) {
    const fs::path small_is_foreign = write("a.mkv", true), main_is_foreign = write("b.mkv", true);
    disown(small_is_foreign, {TrackRole::small});
    disown(main_is_foreign, {TrackRole::main});
    for (const fs::path& file : {small_is_foreign, main_is_foreign}) {
        const auto feed = open_feed(file.string());
        std::int64_t frames = 0;
        while (const auto frame = feed->next()) {
            EXPECT_EQ(frame->posed, file == small_is_foreign);
            EXPECT_EQ(frame->main.rgb.width(), 128);
            EXPECT_FALSE(frame->small) << file << ", frame " << frame->main.info.index;
            ++frames;
        }
        EXPECT_EQ(frames, frame_count) << file;
    }
}

TEST_F(StreamFeeds, APictureThatLostItsDataIsDroppedAndTheRestIsStillOurs) {
    struct Case {
        TrackRole role;
        std::int64_t first, last;
    };
    for (const Case& lost : {Case{TrackRole::main, 4, 4}, Case{TrackRole::small, 4, 4}, Case{TrackRole::main, 0, 0},
                             Case{TrackRole::small, 0, 0}, Case{TrackRole::main, 0, 2}}) {
        SCOPED_TRACE(std::string(track_name(lost.role)) + " from " + std::to_string(lost.first));
        const fs::path file = write("a.mkv", true);
        disown(file, {lost.role}, lost.first, lost.last);
        const auto feed = open_feed(file.string());
        std::int64_t frames = 0, small = 0, earlier = -1;
        while (const auto frame = feed->next()) {
            EXPECT_TRUE(frame->posed);
            EXPECT_GT(frame->main.info.index, earlier);
            earlier = frame->main.info.index;
            EXPECT_NEAR(frame->main.rgb.pixel(64, 32)[1], main_grey(earlier), 3);
            ++frames;
            small += frame->small.has_value();
        }
        const std::int64_t count = lost.last - lost.first + 1;
        EXPECT_EQ(frames, frame_count - (lost.role == TrackRole::main ? count : 0));
        EXPECT_EQ(small, frame_count - count);
        EXPECT_NE(feed->truncation(), "") << "what is missing is said";
    }
}

TEST_F(StreamFeeds, AShortVideoOfSomebodyElseIsNotLost) {
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 128, 64}};
    const fs::path file = folder_ / "short.mkv";
    StreamWriter writer(file.string(), settings);
    for (const std::int64_t index : {0, 1})
        writer.write(TrackRole::main, ByteImage(128, 64, 3, 90).view(), info(index, 128, 64));
    writer.finish();
    disown(file, {TrackRole::main}, 0, 1);
    const auto feed = open_feed(file.string());
    for (const std::int64_t index : {0, 1}) {
        const auto frame = feed->next();
        ASSERT_TRUE(frame);
        EXPECT_FALSE(frame->posed);
        EXPECT_EQ(frame->main.info.index, index);
    }
    EXPECT_FALSE(feed->next());
}

/// Mean of 255.
int brightness_of(const ReceivedPicture& picture) {
    double sum = 0;
    const auto add = [&](const auto& plane, double scale) {
        for (int y = 0; y < picture.height(); ++y)
            for (int x = 0; x < picture.width(); ++x)
                sum += scale * plane.pixel(x, y)[0];
    };
    if (!picture.rgb.empty())
        add(picture.rgb.view(), 1);
    else if (!picture.yuv.empty())
        add(picture.yuv.planes.y, 1);
    else
        add(picture.pq.planes.y, 255.0 / 1023);
    return int(sum / (picture.width() * picture.height()));
}

/// What a file's boxes of these names say is unknown to everybody.
void hide_boxes(const fs::path& file, std::initializer_list<const char*> names) {
    std::ifstream in(file, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    for (const char* name : names)
        for (std::size_t at = bytes.find(name); at != std::string::npos; at = bytes.find(name, at))
            bytes.replace(at, 4, "free");
    std::ofstream(file, std::ios::binary) << bytes;
}

/// VR180, by Google's boxes and by Apple's alone: the front half of a sphere.
TEST_F(StreamFeeds, OtherPeoplesHalfSpheresAreHalves) {
    for (const bool apple : {false, true}) {
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.tagged = false;
        settings.sphere = LongitudeLatitudeRange{-pi / 2, pi / 2, -pi / 2, pi / 2};
        settings.tracks = {{TrackRole::main, 128, 128}};
        const fs::path file = folder_ / "half.mp4";
        StreamWriter writer(file.string(), settings);
        for (const std::int64_t index : {0, 1, 2, 3, 4, 5})
            writer.write(TrackRole::main, ByteImage(128, 128, 3, 100).view(), info(index, 128, 128));
        writer.finish();
        if (apple)
            hide_boxes(file, {"sv3d"});
        const auto frame = open_feed(file.string())->next();
        ASSERT_TRUE(frame);
        EXPECT_FALSE(frame->posed);
        const LongitudeLatitudeRange& range = std::get<EquirectCamera>(frame->main.info.camera).range;
        EXPECT_NEAR(range.longitude_min, -pi / 2, 1e-8);
        EXPECT_NEAR(range.longitude_max, pi / 2, 1e-8);
        EXPECT_NEAR(range.latitude_max, pi / 2, 1e-8);
    }
}

/// Both eyes in each picture: each is a full sphere of its own size.
TEST_F(StreamFeeds, OfOtherPeoplesStereoVideoBothEyesCome) {
    struct Case {
        StereoPacking packing;
        Transfer transfer;
        int width, height;
    };
    for (const auto& [packing, transfer, width, height] : {Case{StereoPacking::top_bottom, Transfer::srgb, 128, 128},
                                                           {StereoPacking::side_by_side, Transfer::srgb, 256, 64},
                                                           {StereoPacking::top_bottom, Transfer::pq, 128, 128},
                                                           {StereoPacking::side_by_side, Transfer::pq, 256, 64}})
        for (const char* name : {"both.mkv", "both.mp4", "apple.mp4"}) {
            SCOPED_TRACE(std::string(name) + " " + std::to_string(int(packing)) + " " + std::to_string(int(transfer)));
            StreamSettings settings;
            settings.preset = "ultrafast";
            settings.transfer = transfer;
            settings.stereo = packing;
            settings.tagged = false;
            settings.tracks = {{TrackRole::main, width, height}};
            const fs::path file = folder_ / name;
            StreamWriter writer(file.string(), settings);
            ByteImage both(width, height, 3, 200);
            FloatImage both_pq(width, height, 3, 0.6f);
            for (int y = 0; y < 64; ++y) {
                std::fill_n(both.pixel(0, y), 3 * 128, std::uint8_t(60));
                std::fill_n(both_pq.pixel(0, y), 3 * 128, 0.3f);
            }
            for (const std::int64_t index : {0, 1, 2, 3, 4, 5})
                if (transfer == Transfer::pq)
                    writer.write_pq(TrackRole::main, both_pq.view(), info(index, width, height));
                else
                    writer.write(TrackRole::main, both.view(), info(index, width, height));
            writer.finish();
            if (name == std::string_view("apple.mp4"))
                hide_boxes(file, {"st3d", "sv3d"});
            for (const bool planes : {false, true}) {
                const auto feed = open_feed(file.string(), {.yuv = planes, .pq = planes});
                int frames = 0;
                while (const auto frame = feed->next()) {
                    ++frames;
                    EXPECT_FALSE(frame->posed);
                    ASSERT_TRUE(frame->right);
                    int brightness[2] = {};
                    for (const ReceivedPicture* eye : {&frame->main, &*frame->right}) {
                        ASSERT_EQ(eye->width(), 128);
                        ASSERT_EQ(eye->height(), 64);
                        EXPECT_TRUE(same_camera(eye->info.camera, EquirectCamera{128, 64, {}}));
                        ASSERT_EQ(eye->rgb.empty(), planes);
                        brightness[eye != &frame->main] = brightness_of(*eye);
                    }
                    EXPECT_GT(brightness[1], brightness[0] + 60);
                }
                EXPECT_EQ(frames, 6);
            }
        }
}

/// Of ours each has its own pose and depth.
TEST_F(StreamFeeds, BothEyesOfOursComeWithTheirPosesAndDepth) {
    for (const StereoPacking packing : {StereoPacking::top_bottom, StereoPacking::side_by_side})
        for (const bool halved : {false, true})
            for (const bool ods : {false, true}) {
                SCOPED_TRACE(std::to_string(int(packing)) + (halved ? " halved" : "") + (ods ? " ods" : ""));
                constexpr int width = 256, height = 128;
                FrameInfo left = info(0, width, height);
                left.head = {{1, 2, 3}, glm::normalize(glm::dquat(0.9, 0, 0.3, 0))};
                left.eye = Eye::left;
                left.lock = AxisLock::path;
                if (ods)
                    std::get<EquirectCamera>(left.camera).ods_side_m = -0.5 * left.ipd_m;
                left.camera_pose = camera_pose(left.camera, left.head, Eye::left, left.ipd_m, left.lock);
                left.packing = packing;
                StreamSettings settings;
                settings.preset = "ultrafast";
                const int both_width = picture_width(left), both_height = picture_height(left);
                settings.tracks = {{TrackRole::main, both_width, both_height},
                                   {TrackRole::depth, both_width, both_height, DepthCodeId::w10, 4, halved}};
                const fs::path file = folder_ / "ours.mkv";
                StreamWriter writer(file.string(), settings);
                const ByteImage colours[] = {ByteImage(width, height, 3, 60), ByteImage(width, height, 3, 200)};
                const FloatImage depths_m[] = {FloatImage(width, height, 1, 2.0f), FloatImage(width, height, 1, 4.0f)};
                for (left.index = 0; left.index < 3; ++left.index) {
                    left.time_s = double(left.index) / 30;
                    writer.write(TrackRole::main, packed_eyes(packing, colours[0].view(), colours[1].view()).view(),
                                 left);
                    FrameInfo depth = left;
                    depth.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.063, 1, false}, 0};
                    writer.write_depth(TrackRole::depth,
                                       packed_eyes(packing, depths_m[0].view(), depths_m[1].view()).view(), depth);
                }
                writer.finish();
                const auto feed = open_feed(file.string(), {.depth = true});
                int frames = 0;
                while (const auto frame = feed->next()) {
                    ++frames;
                    EXPECT_EQ(frame->posed, !ods);
                    ASSERT_TRUE(frame->right);
                    require_tagged_sizes(*frame);
                    const ReceivedPicture* const eyes[] = {&frame->main, &*frame->right};
                    for (int i = 0; i < 2; ++i) {
                        const FrameInfo& found = eyes[i]->info;
                        EXPECT_EQ(found.eye, i == 0 ? Eye::left : Eye::right);
                        EXPECT_EQ(found.packing, StereoPacking::none);
                        EXPECT_EQ(width_of(found.camera), width);
                        EXPECT_EQ(std::get<EquirectCamera>(found.camera).ods_side_m,
                                  ods ? (i == 0 ? -0.5 : 0.5) * left.ipd_m : 0);
                        const glm::dvec3 side = left.head.orientation * glm::dvec3((i - 0.5) * left.ipd_m, 0, 0);
                        EXPECT_LT(glm::distance(found.camera_pose.position_m,
                                                left.head.position_m + (ods ? glm::dvec3(0) : side)),
                                  1e-12);
                        EXPECT_LT(std::abs(brightness_of(*eyes[i]) - (i == 0 ? 60 : 200)), 3);
                        ASSERT_EQ(eyes[i]->depth_m.empty(), ods);
                        for (const float r : eyes[i]->depth_m.samples())
                            ASSERT_NEAR(r, i == 0 ? 2 : 4, 0.1);
                    }
                }
                EXPECT_EQ(frames, 3);
            }
}

TEST_F(StreamFeeds, BytesAreThoseOfTheFramesThatWereGiven) {
    const std::string file = write("a.mkv", true).string();
    std::map<TrackRole, std::vector<std::int64_t>> bytes;
    StreamReader reader(file);
    while (const auto picture = reader.next())
        bytes[picture->role].push_back(picture->bytes);
    for (const StreamTrackSummary& track : reader.tracks()) {
        const auto& of_pictures = bytes.at(track.role);
        EXPECT_EQ(std::accumulate(of_pictures.begin(), of_pictures.end(), std::int64_t{0}), track.bytes);
        EXPECT_GT(of_pictures[0], of_pictures[2]) << "a key frame, then one that is told from it";
    }
    const auto feed = open_feed(file, {.first_frame = first_index + 1, .last_frame = first_index + 3});
    while (feed->next()) {
    }
    ASSERT_EQ(feed->tracks().size(), 2u);
    for (const FeedTrack& track : feed->tracks()) {
        const auto& all = bytes.at(track.name == "main" ? TrackRole::main : TrackRole::small);
        EXPECT_EQ(track.pictures, 3);
        EXPECT_EQ(track.bytes, all[1] + all[2] + all[3]) << track.name;
    }
}

/// The flags of the box `stri`, four letters and four bytes in, have 8 for eyes that are the other way round.
TEST_F(StreamFeeds, EyesThatAreTaggedTheOtherWayRoundAreSwapped) {
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.stereo = StereoPacking::top_bottom;
    settings.tagged = false;
    settings.tracks = {{TrackRole::main, 128, 128}};
    const fs::path file = folder_ / "reversed.mp4";
    StreamWriter writer(file.string(), settings);
    ByteImage both(128, 128, 3, 200);
    for (int y = 0; y < 64; ++y)
        std::fill_n(both.pixel(0, y), 3 * 128, std::uint8_t(60));
    for (const std::int64_t index : {0, 1, 2, 3, 4, 5})
        writer.write(TrackRole::main, both.view(), info(index, 128, 128));
    writer.finish();
    hide_boxes(file, {"st3d", "sv3d"});
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(bytes), {}};
    const std::size_t flags = text.find("stri") + 8;
    ASSERT_LT(flags, text.size());
    bytes.clear();
    bytes.seekp(std::streamoff(flags)).put(char(text[flags] | 8));
    bytes.close();
    for (const bool yuv : {false, true}) {
        const auto frame = open_feed(file.string(), {.yuv = yuv})->next();
        ASSERT_TRUE(frame && frame->right);
        EXPECT_GT(brightness_of(frame->main), brightness_of(*frame->right) + 60);
    }
}

TEST(FrameMaker, TimesAndBytesOfColourAndDepthAddUp) {
    const FeedOptions options;
    int counted = 0;
    FrameMaker maker("a.mkv", options, [&](const DecodedPicture&) { ++counted; });
    DecodedFrame frame;
    for (const TrackRole role : {TrackRole::main, TrackRole::depth}) {
        DecodedPicture& picture = frame.picture(role).emplace();
        const bool is_main = role == TrackRole::main;
        picture.role = role;
        picture.width = 8;
        picture.height = 4;
        picture.info = info(first_index, 8, 4);
        picture.decode_ms = is_main ? 2 : 5;
        picture.convert_ms = is_main ? 3 : 7;
    }
    frame.picture(TrackRole::main)->rgb = ByteImage(8, 4, 3);
    frame.picture(TrackRole::depth)->depth_m = FloatImage(8, 4, 1, 2.0f);
    frame.picture(TrackRole::depth)->info->depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 1, true}, 0};
    EXPECT_EQ(frame.bytes(), 8u * 4 * 3 + 8 * 4 * 4);
    const ReceivedPicture main = maker.make(std::move(frame)).main;
    EXPECT_EQ(main.decode_ms, 7);
    EXPECT_EQ(main.convert_ms, 10);
    EXPECT_EQ(counted, 2);
}

/// Depth and mirrors are of the picture that they came with: of its size, its camera and its pose.
TEST(FrameMaker, WhatBelongsToAPictureIsOfItsView) {
    const FeedOptions options;
    for (const TrackRole role : {TrackRole::depth, TrackRole::reflections})
        for (const char* other : {"", "size", "camera", "pose"}) {
            SCOPED_TRACE(std::string(track_name(role)) + " of another " + other);
            const int height = std::string(other) == "size" ? 5 : 4;
            DecodedFrame frame;
            for (const TrackRole each : {TrackRole::main, role}) {
                DecodedPicture& picture = frame.picture(each).emplace();
                picture.role = each;
                picture.width = 8;
                picture.height = each == role ? height : 4;
                picture.info = info(first_index, 8, 4);
            }
            frame.picture(TrackRole::main)->rgb = ByteImage(8, 4, 3);
            DecodedPicture& beside = *frame.picture(role);
            beside.depth_m = FloatImage(8, height, 1, 2.0f);
            beside.info->depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 1, true}, 0};
            if (std::string(other) == "camera")
                beside.info->camera = PerspectiveCamera{8, 4, 1};
            if (std::string(other) == "pose")
                beside.info->camera_pose.position_m.x += 0.01;
            FrameMaker maker("a.mkv", options, [](const DecodedPicture&) {});
            if (*other == 0) {
                EXPECT_NO_THROW(maker.make(std::move(frame)));
            } else {
                EXPECT_THROW(maker.make(std::move(frame)), WorkError);
            }
        }
}

}  // namespace
}  // namespace equistream::test
