/// Clients of sources that are damaged, and of callers whose time goes back: they show what they can, and go on.
#include "client_folder.h"
#include "watched_client.h"

#include <tests/comma_locale.h>

#include <algorithm>
#include <cfenv>
#include <fstream>

namespace equistream::test {
namespace {

class ClientFailures : public ::testing::Test {
protected:
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    const es_client_settings settings = client_settings(file.c_str());
};

/// Looked up by its tag it would be read beyond its end.
TEST_F(ClientFailures, APictureOfAnotherSizeThanItIsTaggedWithIsPassedOver) {
    write_with(file, {.other_size = {3}});
    WatchedClient watched(settings);
    expect_all_but_one_frame(watched, 3,
                             "frame 3, main: expected a picture of 384x256, as it is tagged, found 192x128");
}

TEST_F(ClientFailures, TheFirstPictureOfTheSizeItIsTaggedWithIsTheFirst) {
    write_with(file, {.other_size = {0, 1}});
    es_client_settings still = settings;
    still.paused = 1;
    WatchedClient watched(still);
    EXPECT_EQ(watched.client.source().width, width);
    const Look look = watched.look();
    EXPECT_EQ(look.problem, "");
    EXPECT_EQ(look.state.frame, 2);
    EXPECT_TRUE(watched.sees_floor());
}

TEST_F(ClientFailures, TheFirstPictureIsSeenHoweverLateItIsAskedFor) {
    write_with(file, {});
    WatchedClient watched(settings);
    EXPECT_EQ(watched.look(10).state.frame, 0);
    EXPECT_EQ(watched.look(1.0 / 60).state.frame, 0);
    EXPECT_EQ(frames_of(watched.watch_all()), (std::vector<std::int64_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST_F(ClientFailures, PicturesOfOtherSizesAloneAreRefused) {
    write_with(file, {.other_size = {0, 1, 2, 3, 4, 5, 6, 7}});
    try {
        const Client client(settings);
        ADD_FAILURE() << "would be read beyond their ends";
    } catch (const ClientError& error) {
        EXPECT_EQ(error.what(),
                  file + ": frame 0, main: expected a picture of 384x256, as it is tagged, found 192x128");
        EXPECT_FALSE(error.is_input);
    }
}

/// The frame before stands for it as of the time that is shown.
TEST_F(ClientFailures, WhatMovesDoesNotJumpBackWhereAFrameCannotBeShown) {
    write_with(file, {.other_size = {3}, .has_motion = true});
    es_client_settings extrapolating = settings;
    extrapolating.max_extrapolation_s = 1;
    WatchedClient watched(extrapolating);
    double longest_s = 0;
    watched.watch([&](const Look& look) {
        const double expected_s = std::max(0.0, look.state.time_s - double(look.state.frame) / 30);
        EXPECT_NEAR(look.state.extrapolation_s, expected_s, 1e-9) << look.state.frame;
        longest_s = std::max(longest_s, look.state.extrapolation_s);
        return look.state.is_over != 0;
    });
    EXPECT_GT(longest_s, 1.2 / 30);
}

/// As with OpenGL.
TEST_F(ClientFailures, WithoutItsDepthAFrameIsTurnedAlone) {
    write_with(file, {.lost_depth = {3}});
    WatchedClient watched(settings);
    EXPECT_EQ(std::string(watched.client.source().engine), "mesh");
    const auto seen = watched.watch([&](const Look& look) {
        EXPECT_EQ(look.problem, "");
        const bool knows_depth = std::ranges::any_of(watched.eyes[0].depth_m, [](float r) { return r > 0; });
        EXPECT_EQ(knows_depth, look.state.frame != 3) << look.state.frame;
        EXPECT_TRUE(watched.sees_floor());
        return look.state.is_over != 0;
    });
    EXPECT_EQ(frames_of(seen).size(), std::size_t(pictures));
}

/// OpenColorIO reads numbers by C++ streams, and divides by zero.
TEST_F(ClientFailures, HdrIsShownToAHostWithALocaleAndTraps) {
    write_hdr(file, 0.5f);
    const testing::CommaLocale of_host;
    constexpr int traps = FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW;
    feenableexcept(traps);
    WatchedClient watched(settings);
    const Look look = watched.look();
    EXPECT_EQ(fedisableexcept(traps), traps) << "they are the host's again";
    EXPECT_EQ(look.problem, "");
    EXPECT_EQ(look.state.frame, 0);
}

TEST_F(ClientFailures, HdrIsShownAtTheExposureThatWasAskedFor) {
    write_hdr(file, 0.5f);
    expect_exposure_by_stops(settings);
}

/// Frames of a second each: they are not extrapolated for that long.
TEST_F(ClientFailures, MovingObjectsAreExtrapolatedAsFarAsTheyMayBe) {
    StreamWriter writer(file, settings_of(Codec::h264, DepthCodeId::w10));
    for (std::int64_t index = 0; index < pictures; ++index) {
        FrameInfo colour = info_of(index), depth = info_of(index, DepthCodeId::w10);
        colour.time_s = depth.time_s = double(index);
        colour.frames_per_second = depth.frames_per_second = 1;
        set_in_motion(colour);
        writer.write(TrackRole::main, synthetic::picture(width, height, index).view(), colour);
        writer.write_depth(TrackRole::depth, depth_of(index).view(), depth);
    }
    writer.finish();
    constexpr double limit_s = 0.001;
    es_client_settings limited = settings;
    limited.max_extrapolation_s = limit_s;
    WatchedClient watched(limited);
    double longest_s = 0;
    for (int i = 0; i < 30; ++i)
        longest_s = std::max(longest_s, watched.look().state.extrapolation_s);
    EXPECT_NEAR(longest_s, limit_s, 1e-12);
}

class FolderClients : public ClientFolder {
protected:
    es_client_settings playing() {
        es_client_settings s = settings();
        s.paused = 0;
        return s;
    }
};

TEST_F(FolderClients, PauseWhereReadingFailedAndGoOnBeyondIt) {
    std::ofstream(folder / "centre" / frame_file_name(1)) << "no picture";
    WatchedClient watched(playing());
    const auto seen = watched.watch([](const Look& look) { return !look.problem.empty(); });
    EXPECT_NE(seen.back().problem.find(frame_file_name(1)), std::string::npos) << seen.back().problem;
    EXPECT_EQ(seen.back().state.frame, 0);
    EXPECT_TRUE(seen.back().state.is_paused);
    EXPECT_EQ(watched.eyes[0].width, watched.request.width);
    const Look again = watched.look();
    EXPECT_EQ(again.problem, "") << "is said once";
    EXPECT_TRUE(again.state.is_paused);
    watched.client.seek(2 / 30.0);
    watched.client.play();
    EXPECT_EQ(watched.watch_all().back().state.frame, 2);
}

/// From there it saw what the ball hides now.
TEST_F(FolderClients, FillFromTheFrameBefore) {
    write_frame(0, {{0.1, 0, 0}, {1, 0, 0, 0}});
    WatchedClient watched(playing());
    const double display_s = watched.request.display_s;
    watched.request = watched.client.request(160, 120, pi / 2);
    watched.request.display_s = display_s;
    watched.watch([](const Look& look) { return look.state.frame == 1; });
    EXPECT_GT(std::ranges::count(watched.eyes[1].origin, ES_ORIGIN_EARLIER), 20);
}

TEST_F(FolderClients, HoldTimeWhilePaused) {
    WatchedClient watched(playing());
    watched.watch([](const Look& look) { return look.state.frame == 1; });
    watched.client.pause();
    const Look held = watched.look(0.5);
    EXPECT_TRUE(held.state.is_paused);
    EXPECT_EQ(held.state.frame, 1);
    EXPECT_EQ(watched.look(0.5).state.time_s, held.state.time_s);
    watched.client.play();
    EXPECT_GT(watched.watch_all().back().state.frame, 1);
}

TEST_F(FolderClients, ThatBeginAgainAreNeverOver) {
    es_client_settings looping = playing();
    looping.loop = 1;
    WatchedClient watched(looping);
    bool was_at_end = false;
    watched.watch([&](const Look& look) {
        EXPECT_FALSE(look.state.is_over);
        was_at_end = was_at_end || look.state.frame == frame_count - 1;
        return was_at_end && look.state.frame == 0;
    });
}

TEST_F(FolderClients, SeekTheFirstFrameThatIsNotBeforeATime) {
    WatchedClient watched(settings());
    watched.client.seek(0.4 / 30);
    EXPECT_EQ(watched.watch([](const Look& look) { return look.state.is_new != 0; }).back().state.frame, 1);
}

/// A display time before the last one counts as the last one.
TEST_F(FolderClients, GoOnWhereTheirCallersTimeGoesBack) {
    WatchedClient watched(settings());
    watched.request.display_s = 1;
    const double before_s = watched.look(0).state.time_s;
    watched.client.play();
    watched.look(-1);
    EXPECT_EQ(watched.look(1).state.time_s, before_s);
    EXPECT_GT(watched.look(0.01).state.time_s, before_s);
}

}  // namespace
}  // namespace equistream::test
