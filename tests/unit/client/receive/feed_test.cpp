#include <tests/unit/client/analytic_scene.h>

#include <client/receive/receive.h>
#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/stream.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <utility>
#include <variant>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

class Feeds : public testing::Test {
protected:
    fs::path folder = fs::temp_directory_path() / ("equistream_feeds_" + std::to_string(::getpid()));
    void SetUp() override { fs::create_directories(folder); }
    void TearDown() override { fs::remove_all(folder); }

    static FrameInfo info(std::int64_t index, int width, int height) {
        FrameInfo info;
        info.index = index;
        info.time_s = double(index) / 30;
        info.camera = EquirectCamera{width, height, {}};
        info.head.position_m = {0.01 * double(index), 1.6, 0};
        info.camera_pose = info.head;
        info.exposure = 2;
        info.scene = "test";
        return info;
    }

    void write_frame(const std::string& view, const FrameInfo& info, float radiance) const {
        const int width = width_of(info.camera), height = height_of(info.camera);
        Frame frame;
        frame.info = info;
        frame.planes["colour"] = FloatImage(width, height, 4, radiance);
        frame.planes["depth"] = FloatImage(width, height, 1, 3.0f + float(info.index));
        fs::create_directories(folder / view);
        write_exr(folder / view / frame_file_name(info.index), frame);
    }
    void write_frame(const std::string& view, std::int64_t index, int width, int height, float radiance) const {
        write_frame(view, info(index, width, height), radiance);
    }
};

TEST_F(Feeds, AFolderGivesMainAndSmallOfEachFrame) {
    for (const std::int64_t index : {3, 4, 7}) {
        write_frame("centre", index, 32, 16, 0.1f);
        if (index != 4)
            write_frame("small", index, 8, 4, 0.2f);
        write_frame("left", index, 32, 16, 0.1f);
    }
    const auto feed = open_feed(folder.string(), {.depth = true});
    EXPECT_EQ(feed->summary().frames, 5) << "from the first to the last";
    std::vector<std::int64_t> seen;
    while (const auto frame = feed->next()) {
        EXPECT_EQ(frame->depth_views.size(), 1u) << "main's depth is not copied again";
        seen.push_back(frame->main.info.index);
        EXPECT_EQ(frame->small.has_value(), frame->main.info.index != 4);
        EXPECT_EQ(frame->main.rgb.width(), 32);
        EXPECT_EQ(frame->main.depth_m.pixel(5, 5)[0], 3.0f + float(frame->main.info.index));
        // sRGB of twice 0.1 (half precision): 124.
        EXPECT_NEAR(frame->main.rgb.pixel(3, 3)[1], 124, 1);
    }
    EXPECT_EQ(seen, (std::vector<std::int64_t>{3, 4, 7}));
    EXPECT_EQ(feed->truncation(), "");
    EXPECT_EQ(feed->fraction_done(), 1.0);
    ASSERT_EQ(feed->tracks().size(), 3u);
    EXPECT_EQ(feed->tracks()[0].pictures, 3);
    EXPECT_EQ(feed->tracks()[1].pictures + feed->tracks()[2].pictures, 2 + 3);
    std::uintmax_t bytes = 0;
    for (const std::int64_t index : {3, 4, 7})
        bytes += fs::file_size(folder / "centre" / frame_file_name(index));
    EXPECT_EQ(feed->tracks()[0].bytes, std::int64_t(bytes));
}

TEST_F(Feeds, AViewWithoutFramesIsNotTheMainOne) {
    fs::create_directories(folder / "centre");
    write_frame("left", 0, 32, 16, 0.1f);
    const auto frame = open_feed(folder.string())->next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->main.rgb.width(), 32);
}

TEST_F(Feeds, ARenamedFrameIsTheOneThatItsNameSays) {
    write_frame("centre", 2, 32, 16, 0.1f);
    for (const std::int64_t copy : {4, 5})
        fs::copy_file(folder / "centre" / frame_file_name(2), folder / "centre" / frame_file_name(copy));
    const auto feed = open_feed(folder.string());
    for (const std::int64_t index : {2, 4, 5}) {
        const auto frame = feed->next();
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->main.info.index, index);
        EXPECT_NEAR(frame->main.info.time_s, double(index) / 30, 1e-9);
    }
}

TEST_F(Feeds, AFrameOfAnotherSizeIsNamed) {
    write_frame("centre", 0, 32, 16, 0.1f);
    write_frame("centre", 1, 16, 8, 0.1f);
    const auto feed = open_feed(folder.string());
    EXPECT_TRUE(feed->next());
    try {
        feed->next();
        FAIL() << "a frame of another size was taken";
    } catch (const InputError& error) {
        EXPECT_EQ(error.what(), (folder / "centre" / "frame.0001.exr").string() +
                                    ": expected 32x16 pixels as in the frames before it, found 16x8");
    }
}

TEST_F(Feeds, AFrameOfAnotherRenderIsNamed) {
    for (const char* view : {"centre", "small"})
        for (const std::int64_t index : {0, 1, 2})
            write_frame(view, index, 32, 16, 0.1f);
    FrameInfo other = info(1, 32, 16);
    other.samples_per_pixel = 7;
    write_frame("small", other, 0.1f);
    const auto feed = open_feed(folder.string());
    EXPECT_TRUE(feed->next());
    try {
        feed->next();
        FAIL() << "a frame of another render was taken";
    } catch (const InputError& error) {
        EXPECT_EQ(error.what(), (folder / "small" / "frame.0001.exr").string() +
                                    ": expected spp 0 as in the frames before it, found 7");
    }
}

/// Layers fill gaps with their colours. Of another eye beside main's depth alone is used.
TEST_F(Feeds, ALayerOfAnotherRenderIsNamed) {
    const auto refusal = [&](const std::string& view, const std::function<void(FrameInfo&)>& change) {
        write_frame("centre", 0, 32, 16, 0.1f);
        FrameInfo other = info(0, 32, 16);
        change(other);
        write_frame(view, other, 0.1f);
        std::string found;
        try {
            open_feed(folder.string(), {.depth = true})->next();
        } catch (const InputError& error) {
            found = error.what();
        }
        fs::remove_all(folder / view);
        return found;
    };
    const auto expected = [&](const char* view, const std::string& what) {
        return (folder / view).string() + ", frame 0: expected the " + what + " of " + (folder / "centre").string() +
               ", found another one; render both with one command, or remove that folder";
    };
    const auto same = [](FrameInfo&) {};
    const auto other_scene = [](FrameInfo& info) { info.scene = "another"; };
    const auto other_path = [](FrameInfo& info) { info.head.position_m.y += 0.01; };
    const auto turned = [](FrameInfo& info) { info.head.orientation = glm::dquat(0.8, 0, 0.6, 0); };
    const auto other_seed = [](FrameInfo& info) { info.seed += 1; };
    const auto other_eye = [](FrameInfo& info) { info.eye = Eye::right; };
    for (const char* view : {"hidden", "patches", "small", "window"}) {
        EXPECT_EQ(refusal(view, same), "");
        EXPECT_EQ(refusal(view, other_scene), expected(view, "scene"));
        EXPECT_EQ(refusal(view, other_path), expected(view, "head position"));
        EXPECT_EQ(refusal(view, turned), expected(view, "head orientation"));
        EXPECT_EQ(refusal(view, other_seed), expected(view, "seed"));
    }
    EXPECT_EQ(refusal("hidden", other_eye), expected("hidden", "eye"));
    EXPECT_EQ(refusal("patches", other_eye), expected("patches", "eye"));
    EXPECT_EQ(refusal("small", other_eye), "");
    EXPECT_EQ(refusal("left", other_scene), expected("left", "scene"));
    EXPECT_EQ(refusal("left", other_path), "");
    EXPECT_EQ(refusal("left", other_seed), "");
}

/// Of omnidirectional stereo the other eye's colours are shown.
TEST_F(Feeds, ARightEyeOfAnotherRenderIsNamed) {
    const auto write = [&](Eye eye, const std::function<void(FrameInfo&)>& change) {
        FrameInfo of_eye = info(0, 32, 16);
        of_eye.eye = eye;
        std::get<EquirectCamera>(of_eye.camera).ods_side_m = ods_side_m(eye, of_eye.ipd_m);
        change(of_eye);
        write_frame(eye == Eye::left ? "left" : "right", of_eye, 0.1f);
    };
    const auto same = [](FrameInfo&) {};
    write(Eye::left, same);
    write(Eye::right, same);
    EXPECT_TRUE(open_feed(folder.string())->next()->right);
    for (const auto& [change, what] : {std::pair<std::function<void(FrameInfo&)>, std::string>(
                                           [](FrameInfo& other) { other.exposure = 3; }, "exposure"),
                                       {[](FrameInfo& other) { other.head.position_m.y += 0.01; }, "head position"}}) {
        write(Eye::right, change);
        try {
            open_feed(folder.string())->next();
            ADD_FAILURE() << "another " << what << " was taken";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("expected the " + what + " of "), std::string::npos)
                << error.what();
        }
    }
}

/// What a feed gave, up to its end or what it threw.
struct Given {
    std::vector<ReceivedFrame> frames;
    std::vector<double> fractions;
    std::vector<std::vector<std::int64_t>> bytes;
    std::string truncation, problem;

    explicit Given(FrameFeed& feed) {
        try {
            while (std::optional<ReceivedFrame> frame = feed.next()) {
                frames.push_back(std::move(*frame));
                fractions.push_back(feed.fraction_done().value_or(-1));
                bytes.emplace_back();
                for (const FeedTrack& track : feed.tracks())
                    bytes.back().push_back(track.bytes);
            }
            truncation = feed.truncation();
        } catch (const InputError& e) {
            problem = e.what();
        } catch (const WorkError& e) {
            problem = e.what();
        }
    }
};

void expect_same(const Given& a, const Given& b) {
    EXPECT_EQ(a.truncation, b.truncation);
    EXPECT_EQ(a.problem, b.problem);
    EXPECT_EQ(a.fractions, b.fractions);
    EXPECT_EQ(a.bytes, b.bytes);
    ASSERT_EQ(a.frames.size(), b.frames.size());
    for (std::size_t i = 0; i < a.frames.size(); ++i) {
        const ReceivedFrame &f = a.frames[i], &g = b.frames[i];
        EXPECT_EQ(f.main.info.index, g.main.info.index);
        EXPECT_TRUE(std::ranges::equal(f.main.rgb.samples(), g.main.rgb.samples()));
        EXPECT_TRUE(std::ranges::equal(f.main.depth_m.samples(), g.main.depth_m.samples()));
        ASSERT_EQ(f.main.yuv.empty(), g.main.yuv.empty());
        for (int y = 0; !f.main.yuv.empty() && y < f.main.height(); ++y)
            EXPECT_TRUE(std::equal(f.main.yuv.planes.y.row(y), f.main.yuv.planes.y.row(y) + f.main.width(),
                                   g.main.yuv.planes.y.row(y)));
        ASSERT_EQ(f.small.has_value(), g.small.has_value());
        if (f.small) {
            EXPECT_TRUE(std::ranges::equal(f.small->rgb.samples(), g.small->rgb.samples()));
        }
    }
}

TEST_F(Feeds, ReadAheadIsTheSameFromFolders) {
    for (std::int64_t index = 0; index < 7; ++index) {
        write_frame("centre", index, 32, 16, 0.1f + 0.05f * float(index));
        if (index != 4)
            write_frame("small", index, 8, 4, 0.2f);
    }
    for (const std::size_t ahead : {1, 2, 20}) {
        const auto plain = open_feed(folder.string(), {.depth = true, .first_frame = 1});
        const auto early = open_feed(folder.string(), {.depth = true, .first_frame = 1, .frames_ahead = ahead});
        const Given a(*plain), b(*early);
        EXPECT_EQ(a.frames.size(), 6u);
        expect_same(a, b);
        EXPECT_FALSE(early->next()) << "after the end";
    }
}

TEST_F(Feeds, WhatFailsAheadIsThrownInItsTurn) {
    for (std::int64_t index = 0; index < 5; ++index)
        write_frame("centre", index, 32, 16, 0.1f);
    fs::resize_file(folder / "centre" / frame_file_name(3), 200);
    const auto plain = open_feed(folder.string());
    const auto early = open_feed(folder.string(), {.frames_ahead = 2});
    const Given a(*plain), b(*early);
    EXPECT_EQ(a.frames.size(), 3u);
    EXPECT_NE(a.problem, "");
    expect_same(a, b);
    EXPECT_ANY_THROW(early->next()) << "again";
    EXPECT_THROW(open_feed((folder / "none").string(), {.frames_ahead = 2}), InputError);
}

TEST_F(Feeds, AFeedThatReadsAheadCanBeLeft) {
    for (std::int64_t index = 0; index < 6; ++index)
        write_frame("centre", index, 32, 16, 0.1f);
    for (int frames = 0; frames < 4; ++frames) {
        const auto feed = open_feed(folder.string(), {.frames_ahead = 2});
        for (int i = 0; i < frames; ++i)
            EXPECT_EQ(feed->next()->main.info.index, i);
    }
}

TEST_F(Feeds, RangesAndMissingFoldersAreChecked) {
    write_frame("left", 0, 32, 16, 0.1f);
    EXPECT_THROW(open_feed(folder.string(), {.first_frame = 1, .last_frame = 9}), InputError);
    EXPECT_THROW(open_feed((folder / "none").string()), InputError);
    fs::create_directories(folder / "empty");
    EXPECT_THROW(open_feed((folder / "empty").string()), InputError);
    std::ofstream(folder / "text.mp4") << "no video";
    EXPECT_THROW(open_feed((folder / "text.mp4").string()), InputError);
}

/// Grey of a picture of write_two_tracks, which tells it from its neighbours.
int grey_of(TrackRole role, std::int64_t index) {
    return (role == TrackRole::main ? 90 : 180) + int(index % 32);
}

/// Both tracks of `count` pictures, but for those that `lost` says.
void write_two_tracks(const fs::path& file, std::int64_t count,
                      const std::function<bool(TrackRole, std::int64_t)>& lost,
                      const std::function<FrameInfo(std::int64_t, int, int)>& info) {
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 128, 64}, {TrackRole::small, 64, 64}};
    StreamWriter writer(file.string(), settings);
    for (std::int64_t index = 0; index < count; ++index) {
        const ByteImage main(128, 64, 3, std::uint8_t(grey_of(TrackRole::main, index)));
        const ByteImage small(64, 64, 3, std::uint8_t(grey_of(TrackRole::small, index)));
        if (!lost(TrackRole::main, index))
            writer.write(TrackRole::main, main.view(), info(index, 128, 64));
        if (!lost(TrackRole::small, index))
            writer.write(TrackRole::small, small.view(), info(index, 64, 64));
    }
    writer.finish();
}

bool small_after_10(TrackRole role, std::int64_t index) {
    return role == TrackRole::small && index >= 10;
}

TEST_F(Feeds, ALostPictureIsNotWaitedFor) {
    const fs::path file = folder / "lost.mkv";
    write_two_tracks(
        file, 120, [](TrackRole role, std::int64_t index) { return index == (role == TrackRole::main ? 20 : 5); },
        info);
    const auto feed = open_feed(file.string());
    std::vector<std::int64_t> seen, expected;
    while (const auto frame = feed->next()) {
        const std::int64_t index = frame->main.info.index;
        seen.push_back(index);
        EXPECT_EQ(frame->small.has_value(), index != 5) << index;
        EXPECT_LE(feed->tracks()[0].pictures, index + 8) << "decoded far ahead";
    }
    for (std::int64_t index = 0; index < 120; ++index)
        if (index != 20)
            expected.push_back(index);
    EXPECT_EQ(seen, expected);
}

TEST_F(Feeds, ATrackThatEndsIsWaitedForOnlySoLong) {
    const fs::path file = folder / "short.mkv";
    write_two_tracks(
        file, 160, [](TrackRole role, std::int64_t index) { return role == TrackRole::small && index >= 40; }, info);
    const auto feed = open_feed(file.string());
    std::int64_t frames = 0;
    for (; const auto frame = feed->next(); ++frames) {
        EXPECT_EQ(frame->main.info.index, frames);
        // The last few stay with the decoder's threads until the whole stream ends.
        EXPECT_TRUE(frame->small.has_value() || frames >= 20) << frames;
        EXPECT_FALSE(frame->small.has_value() && frames >= 40) << frames;
        EXPECT_LE(feed->tracks()[0].pictures, frames + 70);
    }
    EXPECT_EQ(frames, 160);
}

TEST_F(Feeds, AStreamPairsItsTracksByFrame) {
    const fs::path file = folder / "two.mkv";
    write_two_tracks(file, 12, small_after_10, info);
    const auto feed = open_feed(file.string(), {.first_frame = 2});
    std::int64_t expected = 2;
    while (const auto frame = feed->next()) {
        EXPECT_EQ(frame->main.info.index, expected);
        EXPECT_TRUE(frame->posed);
        EXPECT_NEAR(frame->main.rgb.pixel(20, 20)[1], grey_of(TrackRole::main, expected), 3);
        ASSERT_EQ(frame->small.has_value(), expected < 10);
        if (frame->small) {
            EXPECT_EQ(frame->small->info.index, expected);
            EXPECT_NEAR(frame->small->rgb.pixel(4, 4)[1], grey_of(TrackRole::small, expected), 3);
        }
        ++expected;
    }
    EXPECT_EQ(expected, 12);
    EXPECT_EQ(feed->truncation(), "");
}

TEST_F(Feeds, ReadAheadIsTheSameFromStreams) {
    const fs::path file = folder / "two.mkv";
    write_two_tracks(file, 12, small_after_10, info);
    for (const bool yuv : {false, true}) {
        const auto plain = open_feed(file.string(), {.yuv = yuv, .first_frame = 2});
        const auto early = open_feed(file.string(), {.yuv = yuv, .first_frame = 2, .frames_ahead = 2});
        const Given a(*plain), b(*early);
        EXPECT_EQ(a.frames.size(), 10u);
        EXPECT_EQ(a.truncation, "");
        expect_same(a, b);
    }
    fs::resize_file(file, fs::file_size(file) - 200);
    const auto plain = open_feed(file.string()), early = open_feed(file.string(), {.frames_ahead = 1});
    const Given a(*plain), b(*early);
    EXPECT_NE(a.truncation, "");
    expect_same(a, b);
}

/// Whoever shows frames asks while the next ones are read. The thread sanitizer would tell.
TEST_F(Feeds, WhatAStreamSaysOfItselfMayBeAskedWhileItIsReadAhead) {
    const fs::path file = folder / "two.mkv";
    write_two_tracks(file, 40, small_after_10, info);
    const auto plain = open_feed(file.string()), early = open_feed(file.string(), {.frames_ahead = 1});
    while (plain->next()) {
    }
    do {
        EXPECT_EQ(early->transfers().size(), 2U);
        EXPECT_EQ(early->summary().kind, plain->summary().kind);
    } while (early->next());
    EXPECT_EQ(early->transfers(), plain->transfers());
}

}  // namespace
}  // namespace equistream::test
