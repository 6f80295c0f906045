/// What viewers of a live stream are sent and when, who steers it, and how its pace and times are kept.
#include <equistream/viewer_message.h>
#include <programs/serve/pace.h>
#include <programs/serve/programmes.h>
#include <programs/serve/stage_times.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace equistream::serve {
namespace {

const std::string nothing = "\xec\x80";

std::string given(Feed& feed, double elapsed_s) {
    std::array<char, 1 << 16> block;
    const Portion portion = feed.next(block, elapsed_s);
    EXPECT_EQ(portion.problem, "");
    return {block.data(), portion.bytes};
}

TEST(LiveStreams, SayThatTheServerIsThereEverySecond) {
    LiveStream stream([] {});
    const auto feed = stream.open_feed();
    EXPECT_EQ(given(*feed, 5), "") << "nothing may stand before the header";
    stream.set_header("header");
    EXPECT_EQ(given(*feed, 7), "header");
    EXPECT_EQ(given(*feed, 7.9), "");
    std::array<char, 16> block;
    EXPECT_EQ(feed->next(block, 7.9).again_s, 8);
    EXPECT_EQ(given(*feed, 8.1), nothing);
    EXPECT_EQ(given(*feed, 8.2), "");
    stream.publish("picture", true);
    EXPECT_EQ(given(*feed, 8.5), "picture");
    EXPECT_EQ(given(*feed, 9.2), "");
    EXPECT_EQ(given(*feed, 9.6), nothing);
    stream.end();
    EXPECT_EQ(given(*feed, 20), "");
    EXPECT_TRUE(feed->next(block, 20).ended);
}

TEST(LiveStreams, BeginWithAGroupForWhoComesLater) {
    LiveStream stream([] {});
    stream.set_header("header");
    stream.publish("first", true);
    EXPECT_FALSE(stream.take_group_wanted());
    const auto late = stream.open_feed();
    EXPECT_TRUE(stream.take_group_wanted());
    EXPECT_FALSE(stream.take_group_wanted()) << "once";
    stream.publish("second", false);
    EXPECT_EQ(given(*late, 0), "header");
    EXPECT_EQ(given(*late, 0), "") << "it goes on from pictures that this viewer has not";
    stream.publish("third", true);
    stream.publish("fourth", false);
    EXPECT_EQ(given(*late, 0), "third");
    EXPECT_EQ(given(*late, 0), "fourth");
}

TEST(LiveStreams, WhatWasPassedOverWaitsNoMore) {
    LiveStream stream([] {});
    const auto slow = stream.open_feed();
    stream.set_header("header");
    const std::string large(40 << 20, 'x');
    for (int i = 0; i < 3; ++i) {
        stream.publish(large, true);
        std::this_thread::sleep_for(std::chrono::milliseconds(600));
    }
    EXPECT_EQ(stream.spheres_missed(), 2);
    EXPECT_EQ(given(*slow, 2), "header");
    EXPECT_EQ(given(*slow, 2).size(), std::size_t{1} << 14);
}

/// What the system has taken arrives before anything newer. So a line that became narrow gets no more, and what waits
/// can be left out.
TEST(LiveStreams, ALineThatBecameNarrowIsNotGivenMore) {
    LiveStream stream([] {});
    const auto feed = stream.open_feed();
    stream.set_header("header");
    EXPECT_EQ(given(*feed, 0), "header");
    stream.publish(std::string(40000, 'a'), true);
    std::array<char, 1 << 16> block;
    std::size_t under_way = 0;
    for (int pieces = 0; pieces < 2; ++pieces) {
        feed->see_line(0.1, {under_way, 0.04});
        under_way += feed->next(block, 0.1).bytes;
    }
    EXPECT_EQ(under_way, 2 * 16384);
    feed->see_line(0.5, {under_way, 0.04});
    const Portion held = feed->next(block, 0.5);
    EXPECT_EQ(held.bytes, 0);
    EXPECT_TRUE(held.held);
    EXPECT_EQ(held.again_s, 0.52);
    stream.publish(std::string(50000, 'b'), false);
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    EXPECT_GT(stream.delivery()->second.behind_s, 0.5);
    EXPECT_EQ(stream.delivery()->second.bytes_arrived, 6) << "the header alone";
    stream.take_group_wanted();
    stream.publish("after that", false);
    EXPECT_EQ(stream.spheres_missed(), 2);
    feed->see_line(1.2, {under_way, 0.04});
    EXPECT_TRUE(feed->next(block, 1.2).held);
    EXPECT_FALSE(stream.take_group_wanted()) << "it would be old before the line has room";
    feed->see_line(2, {0, 0.04});
    EXPECT_EQ(given(*feed, 2), std::string(40000 - 2 * 16384, 'a')) << "begun, so it must end";
    EXPECT_EQ(given(*feed, 2), "");
    EXPECT_TRUE(stream.take_group_wanted());
    stream.publish("new", true);
    EXPECT_EQ(given(*feed, 2), "new");
    feed->see_line(2, {3, 0.04});
    EXPECT_EQ(feed->next(block, 2).again_s, 2.02) << "until all has arrived";
    EXPECT_EQ(stream.delivery()->second.bytes_arrived, 6 + 40000);
}

/// As where the encoder could not end the stream.
TEST(LiveStreams, NothingIsLeftOutForAGroupWithoutBytes) {
    LiveStream stream([] {});
    const auto feed = stream.open_feed();
    stream.set_header("header");
    EXPECT_EQ(given(*feed, 0), "header");
    stream.publish("a key frame", true);
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    stream.publish("", true);
    EXPECT_EQ(stream.spheres_missed(), 0);
    EXPECT_EQ(given(*feed, 0.6), "a key frame");
}

/// Else each key frame, which takes so long itself, would lead to the next one.
TEST(LiveStreams, NothingIsLeftOutThatIsSoonerSentThanAKeyFrame) {
    LiveStream stream([] {});
    const auto feed = stream.open_feed();
    stream.set_header("header");
    EXPECT_EQ(given(*feed, 0), "header");
    stream.publish("a key frame", true);
    stream.publish("later", false);
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    EXPECT_EQ(given(*feed, 0.6), "a key frame");
    stream.publish("later", false);
    EXPECT_EQ(stream.spheres_missed(), 0);
    stream.publish("more", false);
    EXPECT_EQ(stream.spheres_missed(), 0);
    stream.publish("too much", false);
    EXPECT_EQ(stream.spheres_missed(), 4) << "14 bytes waited, and a key frame has 11";
}

/// One that only looks around leaves the path to the scene, also when who steered has gone.
TEST(LiveStreams, AreNotSteeredByWhoOnlyLooks) {
    LiveStream stream([] {});
    auto moves = stream.open_feed();
    const auto looks = stream.open_feed();
    const auto hear = [](Feed& feed, bool steers) {
        const auto message = encode_viewer_pose({0, {{0.3, 0, 0}, {1, 0, 0, 0}}, {}, steers});
        feed.hear({reinterpret_cast<const char*>(message.data()), message.size()});
    };
    hear(*looks, false);
    EXPECT_FALSE(stream.steering());
    EXPECT_TRUE(stream.gaze(0)) << "a window lies there";
    hear(*moves, true);
    EXPECT_TRUE(stream.steering());
    moves.reset();
    EXPECT_FALSE(stream.steering()) << "its echo stays nowhere";
}

/// The line that a stream is fitted to is that of whoever steers.
TEST(LiveStreams, TellHowTheViewerThatSteersKeepsUp) {
    LiveStream stream([] {});
    EXPECT_FALSE(stream.delivery());
    const auto first = stream.open_feed(), second = stream.open_feed();
    EXPECT_EQ(stream.delivery()->first, 1) << "while nobody steers";
    const auto message = encode_viewer_pose({0, {{0.3, 0, 0}, {1, 0, 0, 0}}, {}});
    second->hear({reinterpret_cast<const char*>(message.data()), message.size()});
    EXPECT_EQ(stream.delivery()->first, 2);
}

TEST(LiveStreams, KeepNoMoreThanSoMuchForOneThatDoesNotRead) {
    LiveStream stream([] {});
    const auto waits = stream.open_feed(), reads = stream.open_feed();
    stream.set_header("header");
    const std::string mebibyte(1 << 20, 'x');
    std::array<char, 1 << 16> block;
    for (int i = 0; i < 65; ++i) {
        stream.publish(mebibyte, true);
        while (reads->next(block, i).bytes > 0) {
        }
    }
    EXPECT_EQ(waits->next(block, 65).problem, "the viewer is too far behind");
    EXPECT_EQ(reads->next(block, 65).problem, "");
}

/// One that reads slowly goes on with the next group; one that reads gets all.
TEST(LiveStreams, GoOnWithTheNextGroupWhereOneIsBehind) {
    LiveStream stream([] {});
    const auto slow = stream.open_feed(), reads = stream.open_feed();
    stream.set_header("header");
    std::string all;
    const auto publish = [&](const std::string& bytes, bool begins_group) {
        stream.publish(bytes, begins_group);
        for (std::string more = "?"; !more.empty(); all += more)
            more = given(*reads, 0);
    };
    publish("first", true);
    publish("second", false);
    EXPECT_EQ(given(*slow, 0), "header");
    slow->see_line(0, {});
    EXPECT_EQ(stream.delivery()->first, 1);
    EXPECT_EQ(stream.delivery()->second.bytes_arrived, 6);
    publish("third", true);
    EXPECT_EQ(stream.spheres_missed(), 0) << "it is not late yet";
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    EXPECT_GT(stream.delivery()->second.behind_s, 0.5);
    stream.take_group_wanted();
    publish("fourth", false);
    EXPECT_EQ(stream.spheres_missed(), 4);
    EXPECT_EQ(given(*slow, 1), nothing) << "no group begins with it";
    EXPECT_TRUE(stream.take_group_wanted());
    EXPECT_EQ(given(*slow, 1.5), "");
    EXPECT_FALSE(stream.take_group_wanted()) << "no more than one a second";
    publish("fifth", true);
    EXPECT_EQ(stream.spheres_missed(), 4);
    EXPECT_EQ(given(*slow, 1.5), "fifth");
    EXPECT_EQ(all, "headerfirstsecondthirdfourthfifth");
}

/// A part that was begun has to end, or nothing behind it could be read.
TEST(LiveStreams, EndWhatWasBegunBeforeTheyPassOverTheRest) {
    LiveStream stream([] {});
    const auto feed = stream.open_feed();
    stream.set_header("header");
    std::array<char, 4> block;
    const auto next = [&] { return std::string(block.data(), feed->next(block, 0).bytes); };
    EXPECT_EQ(next(), "head");
    stream.publish("first", true);
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    stream.publish("new", true);
    EXPECT_EQ(next(), "er");
    EXPECT_EQ(next(), "new");
    EXPECT_EQ(stream.spheres_missed(), 1);
}

/// Clients find their own poses again in what was rendered for them. A gaze is foretold, but not of poses of long ago:
/// a busy machine may say them too slowly, and then another viewer tries again.
TEST(LiveStreams, AreSteeredByPosesAsTheyWereSaid) {
    for (int tries = 0; tries < 100; ++tries) {
        LiveStream stream([] {});
        const auto feed = stream.open_feed();
        EXPECT_FALSE(stream.steering());
        const auto start = Clock::now();
        Pose said;
        for (int i = 0; i < 4; ++i) {
            said = {{0.01 * i, 0, 0}, glm::angleAxis(0.1 * i, glm::dvec3(0, 1, 0))};
            const auto message = encode_viewer_pose({0, said, {}});
            feed->hear({reinterpret_cast<const char*>(message.data()), message.size()});
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        const std::optional<Pose> steering = stream.steering();
        ASSERT_TRUE(steering);
        EXPECT_EQ(steering->position_m, said.position_m);
        EXPECT_EQ(steering->orientation, said.orientation);
        const double said_x = (said.orientation * glm::dvec3(0, 0, -1)).x;
        const double foretold_x = stream.gaze(0.1)->x;
        if (seconds_since(start) < 0.15) {
            EXPECT_LT(foretold_x, said_x) << "it turns on to the left";
            return;
        }
    }
    FAIL() << "no four poses were said within 0.15 s";
}

/// A head that had turned away between two questions left no gaze at all, and their mean was no direction.
TEST(LiveStreams, LookWhereTheFirstLooksWhoeverElseAgrees) {
    const glm::dvec3 ahead(0, 0, -1), behind(0, 0, 1), aside = glm::normalize(glm::dvec3(0.2, 0, -1));
    EXPECT_EQ(mean_gaze(std::array{ahead}), ahead);
    EXPECT_EQ(mean_gaze(std::array{ahead, behind, behind}), ahead);
    const glm::dvec3 mean = mean_gaze(std::array{ahead, aside, behind});
    EXPECT_GT(mean.x, 0);
    EXPECT_LT(mean.x, aside.x);
    EXPECT_NEAR(glm::length(mean), 1, 1e-12);
}

/// The quality of a live stream follows from picture to picture, and each one says which it has.
TEST(LiveStreams, AreCodedCoarserFromOnePictureToTheNext) {
    const synthetic::Folder folder;
    const std::string file = (folder / "live.mkv").string();
    std::size_t bytes = 0;
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 192, 96}};
    settings.live = true;
    StreamWriter writer(file, settings,
                        StreamTap{[&](std::span<const std::uint8_t> more) { bytes += more.size(); }, false});
    int index = 0;
    const auto size_of_next = [&] {
        const std::size_t before = bytes;
        writer.write(TrackRole::main, synthetic::picture(192, 96, index).view(), synthetic::info(192, 96, index));
        writer.flush();
        ++index;
        return bytes - before;
    };
    const auto size_of_key_frame = [&] {
        writer.begin_group();
        const std::size_t size = size_of_next();
        for (int i = 0; i < 3; ++i)
            size_of_next();
        return size;
    };
    const std::size_t fine = size_of_key_frame();
    writer.set_crf(TrackRole::main, 34);
    const std::size_t coarse = size_of_key_frame();
    writer.set_crf(TrackRole::main, settings.crf);
    const std::size_t fine_again = size_of_key_frame();
    EXPECT_LT(double(coarse), 0.6 * double(fine)) << "also right after pictures that were coded finely";
    EXPECT_NEAR(double(fine_again), double(fine), 0.1 * double(fine));
    EXPECT_THROW(writer.set_crf(TrackRole::main, 52), InputError);
    writer.finish();
    StreamReader reader(file);
    std::vector<float> crf;
    while (const auto picture = reader.next())
        crf.push_back(*picture->info->crf);
    EXPECT_EQ(crf, (std::vector<float>{16, 16, 16, 16, 34, 34, 34, 34, 16, 16, 16, 16, 16}));
}

TEST(LiveStreams, ReadersPassOverIt) {
    const synthetic::Folder folder;
    std::string pending, sent;
    LiveStream stream([] {});
    const auto feed = stream.open_feed();
    double now_s = 0;
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 192, 96}};
    settings.live = true;
    StreamWriter writer("live.mkv", settings, StreamTap{.take = [&](std::span<const std::uint8_t> bytes) {
                            pending.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                        }});
    const auto pass_on = [&](bool begins_group) {
        if (begins_group && sent.empty())
            stream.set_header(pending);
        else
            stream.publish(pending, true);
        pending.clear();
        for (int i = 0; i < 2; ++i)  // and then nothing, for longer than may be silence
            sent += given(*feed, now_s += 2);
    };
    pass_on(true);
    constexpr int pictures = 5;
    for (int index = 0; index < pictures; ++index) {
        if (index % 2 == 0)
            writer.begin_group();
        writer.write(TrackRole::main, synthetic::picture(192, 96, index).view(), synthetic::info(192, 96, index));
        writer.flush();
        pass_on(false);
    }
    writer.finish();
    pass_on(false);
    EXPECT_NE(sent.find(nothing + std::string("\x1f\x43\xb6\x75")), std::string::npos) << "before a cluster";
    std::ofstream(folder / "sent.mkv", std::ios::binary) << sent;
    StreamReader reader((folder / "sent.mkv").string());
    int read = 0;
    while (const auto picture = reader.next()) {
        ASSERT_TRUE(picture->info);
        EXPECT_EQ(picture->info->index, read++);
    }
    EXPECT_EQ(read, pictures + 1) << "the last one comes once more, to say so";
    EXPECT_EQ(reader.truncation(), "");
}

}  // namespace

// Samples a pixel that keep up with a rate, for machines on which a sphere takes a part of its own and a part a
// sample.

namespace {

std::vector<std::uint32_t> run(Pace& pace, int spheres, double fixed_s, double sample_s) {
    std::vector<std::uint32_t> samples;
    for (int i = 0; i < spheres; ++i) {
        samples.push_back(pace.samples().looked_at);
        pace.took(fixed_s + sample_s * pace.samples().looked_at);
    }
    return samples;
}

TEST(Pace, RisesWhileThereIsTimeAndNoHigherThanTold) {
    Pace pace(12, 2, false);
    const auto samples = run(pace, 20, 0.01, 0.001);
    EXPECT_EQ(samples.front(), 1u);
    EXPECT_TRUE(std::ranges::is_sorted(samples));
    EXPECT_EQ(samples[2], 2u);
    EXPECT_EQ(samples.back(), 12u);
}

TEST(Pace, StaysWhereTheRateIsKept) {
    Pace pace(64, 2, false);
    const auto samples = run(pace, 400, 0.05, 0.07);
    EXPECT_EQ(samples.back(), 4u);  // 0.33 s of 0.5 s; eight take 0.61 s
    EXPECT_LE(std::ranges::max(samples), 4u);
}

TEST(Pace, HalvesAfterTwoSlowOnesAndIsSlowToTryAgain) {
    Pace pace(16, 2, false);
    run(pace, 20, 0.01, 0.001);
    EXPECT_EQ(pace.samples().looked_at, 16u);
    EXPECT_EQ(pace.took(0.6), Pace::Change::none);
    EXPECT_EQ(pace.took(0.1), Pace::Change::none);  // that was somebody else's doing
    EXPECT_EQ(pace.took(0.6), Pace::Change::none);
    EXPECT_EQ(pace.took(0.6), Pace::Change::fewer);
    EXPECT_EQ(pace.samples().looked_at, 8u);
    for (int i = 0; i < 7; ++i)
        pace.took(0.1);
    EXPECT_EQ(pace.samples().looked_at, 8u);
    pace.took(0.1);
    EXPECT_EQ(pace.samples().looked_at, 16u);
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> run_window(Pace& pace, int spheres, double sphere_s) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> samples;
    for (int i = 0; i < spheres; ++i) {
        const Samples now = pace.samples();
        if (samples.empty() || samples.back() != std::pair(now.looked_at, *now.base))
            samples.emplace_back(now.looked_at, *now.base);
        pace.took(sphere_s);
    }
    return samples;
}

TEST(Pace, SamplesGoToTheWindowFirstAndLeaveTheBaseFirst) {
    Pace pace(4, 2, true);
    using Steps = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
    EXPECT_EQ(run_window(pace, 20, 0.01), (Steps{{1, 1}, {2, 1}, {4, 1}, {4, 2}, {4, 4}}));
    EXPECT_EQ(run_window(pace, 20, 0.9), (Steps{{4, 4}, {4, 2}, {4, 1}, {2, 1}, {1, 1}}));
    EXPECT_EQ(run_window(pace, 40, 0.01).back(), std::pair(4u, 4u));  // one slow spell counts once
    EXPECT_EQ(samples_text(Pace(4, 2, true).samples()), "1 sample a pixel in the window, 1 around it");
    EXPECT_FALSE(Pace(4, 2, false).samples().base);
}

TEST(Pace, SaysOnceThatOneSampleIsTooSlow) {
    Pace pace(16, 2, false);
    int said = 0;
    for (int i = 0; i < 50; ++i)
        said += pace.took(0.9) == Pace::Change::cannot_keep_up ? 1 : 0;
    EXPECT_EQ(said, 1);
    EXPECT_EQ(pace.samples().looked_at, 1u);
}

TEST(StageTimes, AreOfTheLatestSpheresAlone) {
    StageTimes times;
    for (int i = 0; i < 1500; ++i)
        times.add(LiveStage::render, i < 500 ? 5.0 : 0.25);
    const auto json = times.json();
    EXPECT_EQ(json.size(), 1u) << "of stages that there were";
    EXPECT_EQ(json["render"]["samples"], 1000);
    for (const char* figure : {"p50", "p99", "mean"})
        EXPECT_EQ(json["render"][figure], 250.0) << figure;
}

TEST(Pace, TriesAgainAfterSixtyFourQuickOnesAtTheLatest) {
    Pace pace(2, 2, false);
    std::vector<int> needed;
    for (int round = 0; round < 7; ++round) {
        for (needed.push_back(0); pace.samples().looked_at == 1 && needed.back() < 1000; ++needed.back())
            pace.took(0.1);
        pace.took(0.6);
        EXPECT_EQ(pace.took(0.6), Pace::Change::fewer);
    }
    EXPECT_EQ(needed, (std::vector<int>{2, 8, 16, 32, 64, 64, 64}));
}

}  // namespace
}  // namespace equistream::serve
