/// What is shown when: of a folder, on a time that the test makes up, and of a server that stalls, goes and comes back.
#include "frames_folder.h"
#include "paced_server.h"

#include <tests/unit/pipe_writer.h>

#include <client/playback/playback.h>

#include <equistream/error.h>
#include <equistream/stream.h>

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <fstream>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace equistream::test {
namespace {

constexpr double refresh_s = 1.0 / 90;

struct Refresh {
    double now_s;
    double time_s;
    std::int64_t shown;  ///< index of the frame; -1: none so far
    ClockState state;
    bool is_over;
};

class RecordedPlayback : public FramesFolder {
protected:
    /// Time that the test makes up goes on by refreshes; reading takes the time that it takes.
    std::vector<Refresh> watch(Playback& playback, const std::function<bool(const Refresh&)>& until) {
        std::vector<Refresh> seen;
        for (int i = 0; i < 20000; ++i, now_s_ += refresh_s, doze()) {
            const Playback::Moment moment = playback.refresh(now_s_);
            if (moment.frame)
                shown_ = moment.frame->main.info.index;
            seen.push_back({now_s_, playback.time_s(), shown_, playback.state(), moment.is_over});
            if (until(seen.back()))
                return seen;
        }
        ADD_FAILURE() << "nothing came of it within 20 s";
        return seen;
    }
    static std::vector<std::int64_t> frames_of(const std::vector<Refresh>& seen) {
        std::vector<std::int64_t> frames;
        for (const Refresh& refresh : seen)
            if (frames.empty() || frames.back() != refresh.shown)
                frames.push_back(refresh.shown);
        return frames;
    }
    void write_frames_of_two_seconds(int count) const { write_frames(range(0, count - 1), 0.5); }
    /// What a jump or a step leads to.
    std::int64_t arrive(Playback& playback) {
        watch(playback, [&](const Refresh&) { return !playback.is_moving(); });
        return shown_;
    }

    double now_s_ = 3;
    std::int64_t shown_ = -1;
};

TEST_F(RecordedPlayback, ShowsEveryFrameInItsTurnAndThenIsOver) {
    FrameLoader loader(folder.string(), {});
    Playback playback(loader);
    const auto seen = watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    EXPECT_EQ(seen.front().shown, 0) << "the first refresh has something to show";
    EXPECT_EQ(frames_of(seen), range(0, frame_count - 1));
    for (std::size_t i = 1; i < seen.size(); ++i) {
        ASSERT_GE(seen[i].time_s, seen[i - 1].time_s) << i;
        // Never faster than its own pace by more than it takes to come level after the start.
        ASSERT_LE(seen[i].time_s - seen[i - 1].time_s, 1.5 * refresh_s) << i;
        ASSERT_GE(seen[i].time_s + 1e-6, double(seen[i].shown) * interval_s) << i;
        ASSERT_LT(seen[i].time_s, double(seen[i].shown + 1) * interval_s + refresh_s) << i;
    }
    EXPECT_FALSE(playback.refresh(now_s_ + refresh_s).is_over) << "said once";
}

/// All of a short one is read before its time begins: then nothing waits, and it plays at the pace of its frames.
TEST_F(RecordedPlayback, KeepsThePaceOfItsFrames) {
    for (int index = 3; index < frame_count; ++index)
        std::filesystem::remove(folder / "centre" / frame_file_name(index));
    FrameLoader loader(folder.string(), {});
    Playback playback(loader, true);
    watch(playback, [&](const Refresh&) { return loader.state().ended; });
    playback.play();
    const auto seen = watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    // Three intervals of three refreshes each, and at most 0.1 s to come up to speed.
    EXPECT_GE(seen.size(), 9U);
    EXPECT_LE(seen.size(), 18U);
}

/// Slower than a frame a second too: the last one is shown as long as the others.
TEST_F(RecordedPlayback, ShowsFramesOfTwoSecondsForTwoSeconds) {
    write_frames_of_two_seconds(2);
    FrameLoader loader(folder.string(), {});
    Playback playback(loader, true);
    watch(playback, [&](const Refresh&) { return loader.state().ended; });
    playback.play();
    const auto seen = watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    EXPECT_NEAR(double(seen.size()) * refresh_s, 4, 0.2);
}

/// The clock knows how far frames are apart from two of them.
TEST_F(RecordedPlayback, APictureAloneOrSoughtIsShownForItsTimeAndEnds) {
    for (const int pictures : {1, 2}) {
        write_frames_of_two_seconds(pictures);
        FrameLoader loader(folder.string(), {});
        Playback playback(loader, true);
        watch(playback, [&](const Refresh&) { return loader.state().ended; });
        playback.seek(2.0 * (pictures - 1));
        watch(playback, [&](const Refresh&) { return playback.shown_s().has_value(); });
        playback.play();
        const auto seen = watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
        EXPECT_NEAR(double(seen.size()) * refresh_s, 2, 0.2) << pictures;
    }
}

/// Between frames what moves goes on with time; a frame that was stepped to is shown as it is.
TEST_F(RecordedPlayback, WhatMovesIsLaterThanItsFrameAsTimeIs) {
    FrameLoader loader(folder.string(), {});
    Playback playback(loader);
    double max_s = 0;
    watch(playback, [&](const Refresh& refresh) {
        const double extrapolation_s = playback.extrapolation_s(0.2, 0.03);
        EXPECT_NEAR(extrapolation_s, std::max(0.0, refresh.time_s - double(refresh.shown) * interval_s), 1e-9);
        max_s = std::max(max_s, extrapolation_s);
        return refresh.shown == 4;
    });
    EXPECT_GT(max_s, 0.4 * interval_s);
    playback.pause();
    playback.seek(2 * interval_s);
    watch(playback, [&](const Refresh&) { return !playback.is_moving(); });
    EXPECT_EQ(playback.extrapolation_s(0.2), 0);
}

TEST_F(RecordedPlayback, TimeWaitsForReadingAndRushesNothingAfterIt) {
    std::atomic<int> allowed = 2;
    FrameLoader loader(folder.string(), {.left_out = [&] {
                           while (allowed <= 0)
                               doze();
                           return --allowed, TrackRoles{};
                       }});
    Playback playback(loader);
    int waited = 0;
    watch(playback, [&](const Refresh& refresh) { return refresh.shown == 1 && ++waited > 200; });
    EXPECT_LE(playback.time_s(), 2 * interval_s + 1e-6);
    allowed = frame_count;
    const auto seen = watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    EXPECT_EQ(frames_of(seen), range(1, frame_count - 1));
    for (std::size_t i = 1; i < seen.size(); ++i)
        ASSERT_LE(seen[i].time_s - seen[i - 1].time_s, 1.5 * refresh_s) << i;
}

TEST_F(RecordedPlayback, CountsWhatIsMissingAndNothingElse) {
    for (const int missing : {3, 7, 8})
        std::filesystem::remove(folder / "centre" / frame_file_name(missing));
    FrameLoader loader(folder.string(), {});
    Playback playback(loader);
    watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    EXPECT_EQ(playback.counts().lost, 3);
    EXPECT_EQ(playback.counts().late, 0);
    EXPECT_EQ(loader.seconds(), frame_count * interval_s);
    playback.seek(9 * interval_s);
    watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    EXPECT_EQ(playback.counts().lost, 3) << "a jump loses nothing";
}

TEST_F(RecordedPlayback, PausesStepsAndJumps) {
    FrameLoader loader(folder.string(), {});
    Playback playback(loader, true);
    watch(playback, [&](const Refresh& refresh) { return refresh.now_s > 4; });
    EXPECT_EQ(shown_, 0);
    EXPECT_EQ(playback.time_s(), 0);
    EXPECT_FALSE(playback.is_moving());
    for (const std::int64_t next : {1, 2, 3}) {
        playback.step();
        EXPECT_TRUE(playback.is_moving());
        watch(playback, [&](const Refresh&) { return !playback.is_moving(); });
        EXPECT_EQ(shown_, next);
        EXPECT_NEAR(playback.time_s(), double(next) * interval_s, 1e-9);
    }
    playback.seek(1 * interval_s);
    watch(playback, [&](const Refresh&) { return !playback.is_moving(); });
    EXPECT_EQ(shown_, 1);
    playback.seek(8 * interval_s);
    playback.play();
    const auto seen = watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    EXPECT_EQ(frames_of({seen.begin() + 1, seen.end()}).back(), frame_count - 1);
    EXPECT_FALSE(std::ranges::any_of(seen, [](const Refresh& r) { return r.shown > 1 && r.shown < 8; }));
    playback.pause();
    playback.play();  // what is over begins anew
    const auto again = watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    EXPECT_EQ(frames_of(again), ([&] {
                  auto all = range(0, frame_count - 1);
                  if (again.front().shown == frame_count - 1)
                      all.insert(all.begin(), frame_count - 1);
                  return all;
              }()));
}

TEST_F(RecordedPlayback, BehindTheLastFrameThereIsNothingToShow) {
    FrameLoader loader(folder.string(), {});
    Playback playback(loader);
    playback.seek(100);
    EXPECT_TRUE(watch(playback, [](const Refresh& refresh) { return refresh.is_over; }).back().is_over);
    for (int i = 1; i < 5; ++i)
        EXPECT_FALSE(playback.refresh(now_s_ + i * refresh_s).is_over) << "said once";
    EXPECT_EQ(playback.time_s(), 100);
}

TEST_F(RecordedPlayback, JumpsToTheFirstFrameThatIsNotBeforeATime) {
    FrameLoader loader(folder.string(), {});
    Playback playback(loader, true);
    for (const auto& [sought, expected] : {std::pair{5.4, 6}, {5.6, 6}, {6.0, 6}, {2 + 1e-6, 2}, {2 - 1e-6, 2}}) {
        playback.seek(sought * interval_s);
        watch(playback, [&](const Refresh&) { return !playback.is_moving(); });
        EXPECT_EQ(shown_, expected) << sought;
    }
}

/// Frames of a live scene are numbered by its own rate, of which it renders few.
TEST_F(RecordedPlayback, BackLeadsToTheFrameBeforeWhereNumbersAreMissing) {
    write_frames({0, 15, 30, 90}, 30);
    FrameLoader loader(folder.string(), {});
    Playback playback(loader, true);
    playback.seek(90 * interval_s);
    EXPECT_EQ(arrive(playback), 90);
    for (const std::int64_t expected : {30, 15, 0, 0}) {
        playback.seek_back(double(shown_ - 1) * interval_s);
        EXPECT_EQ(arrive(playback), expected);
    }
    for (const std::int64_t expected : {15, 30, 90}) {
        playback.step();
        EXPECT_EQ(arrive(playback), expected);
    }
    playback.seek_back(90 * interval_s - 1);
    EXPECT_EQ(arrive(playback), 30) << "a second back";
    playback.step();
    EXPECT_EQ(arrive(playback), 90) << "it was read by the search";
}

TEST_F(RecordedPlayback, BackLeadsToTheTimeThatIsSoughtWhereThereAreFramesBetween) {
    FrameLoader loader(folder.string(), {});
    Playback playback(loader, true);
    playback.seek(10 * interval_s);
    EXPECT_EQ(arrive(playback), 10);
    for (const std::int64_t expected : {9, 4, 3}) {
        playback.seek_back(double(expected) * interval_s);
        EXPECT_EQ(arrive(playback), expected);
    }
}

TEST_F(RecordedPlayback, OnLeadsNoFartherThanToTheLastFrame) {
    FrameLoader loader(folder.string(), {});
    Playback playback(loader, true);
    const double seconds = loader.seconds().value_or(0), last_s = (frame_count - 1) * interval_s;
    for (const int from : {0, 5, frame_count - 2}) {
        playback.seek(playback.time_on_s(from * interval_s, 1, seconds));
        const auto seen = watch(playback, [&](const Refresh&) { return !playback.is_moving(); });
        EXPECT_EQ(shown_, frame_count - 1) << from;
        EXPECT_FALSE(std::ranges::any_of(seen, &Refresh::is_over)) << from;
    }
    EXPECT_EQ(playback.time_on_s(last_s, 1, seconds), last_s) << "there is nothing farther on";
    EXPECT_DOUBLE_EQ(playback.time_on_s(2 * interval_s, 3 * interval_s, seconds), 5 * interval_s);
    EXPECT_EQ(playback.time_on_s(last_s, 1, 0), last_s + 1) << "nobody knows how long it is";
    EXPECT_DOUBLE_EQ(playback.time_on_s(last_s + 2, 1, seconds), last_s + 3) << "it is longer than was said";
}

TEST_F(RecordedPlayback, APipeIsPlayedOnceWithoutJumps) {
    constexpr int pictures = 12;
    std::string bytes;
    for (const std::vector<char>& part : coded(pictures))
        bytes.append(part.begin(), part.end());
    const std::string pipe = (folder / "pipe.mkv").string();
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const PipeWriter writing(pipe, bytes);
    FrameLoader loader(pipe, {});
    Playback playback(loader);
    EXPECT_FALSE(playback.can_jump());
    watch(playback, [](const Refresh& refresh) { return refresh.shown == 3; });
    playback.seek(0);
    playback.seek_back(0);
    const auto seen = watch(playback, [](const Refresh& refresh) { return refresh.is_over; });
    EXPECT_EQ(frames_of(seen), range(3, pictures - 1));
    playback.pause();
    playback.play();
    EXPECT_TRUE(playback.is_paused()) << "there is nothing to begin anew";
    EXPECT_EQ(playback.refresh(now_s_ + refresh_s).frame, nullptr);
    EXPECT_FALSE(loader.state().failed);
}

TEST_F(RecordedPlayback, AFailureComesAfterWhatCouldBeReadAndPauses) {
    std::ofstream(folder / "centre" / frame_file_name(3)) << "no picture";
    FrameLoader loader(folder.string(), {});
    Playback playback(loader);
    EXPECT_THROW(watch(playback, [](const Refresh&) { return false; }), std::exception);
    EXPECT_EQ(shown_, 2);
    EXPECT_TRUE(playback.is_paused());
    EXPECT_EQ(playback.refresh(now_s_ + refresh_s).frame, nullptr);
}

class LivePlayback : public RecordedPlayback {
protected:
    static constexpr int pictures = 24;
    std::vector<std::vector<char>> parts = coded(pictures);
    PoseSender poses;

    /// In real time, as servers are.
    std::vector<Refresh> watch_live(FrameLoader& loader, Playback& playback,
                                    const std::function<bool(const Refresh&)>& until) {
        std::vector<Refresh> seen;
        for (int i = 0; i < 60000; ++i, doze()) {
            const double now_s = loader.now_s();
            const Playback::Moment moment = playback.refresh(now_s);
            if (moment.frame)
                shown_ = moment.frame->main.info.index;
            seen.push_back({now_s, playback.time_s(), shown_, playback.state(), moment.is_over});
            if (until(seen.back()))
                return seen;
        }
        ADD_FAILURE() << "nothing came of it within a minute";
        return seen;
    }
    /// Never back, and forward at most as fast as the clock may; a refresh that was held up for a second is a cut.
    static void expect_calm(const std::vector<Refresh>& seen) {
        const MediaClockOptions clock;
        for (std::size_t i = 1; i < seen.size(); ++i) {
            const double elapsed_s = seen[i].now_s - seen[i - 1].now_s;
            ASSERT_GE(seen[i].time_s, seen[i - 1].time_s) << i;
            ASSERT_GE(seen[i].shown, seen[i - 1].shown) << i;
            if (elapsed_s < clock.pause_s) {
                ASSERT_LE(seen[i].time_s - seen[i - 1].time_s, clock.max_rate * elapsed_s + 1e-9) << i;
            }
        }
    }
};

TEST_F(LivePlayback, AStallIsCalmAndSoIsWhatComesAfterIt) {
    PacedServer server;
    server.give(parts, 0, pictures / 2);
    FrameLoader loader(server.address(), {});
    ASSERT_TRUE(loader.is_live());
    Playback playback(loader);
    const auto before = watch_live(loader, playback, [](const Refresh& r) { return r.state == ClockState::stalled; });
    expect_calm(before);
    const double stalled_at_s = playback.time_s();
    EXPECT_GT(playback.overdue_s(), 0);
    EXPECT_GE(shown_, 1);
    EXPECT_LT(shown_, pictures / 2);
    EXPECT_EQ(playback.attempts(), 0) << "silent is not gone";
    server.give(parts, pictures / 2, pictures);
    server.close();
    const auto after = watch_live(loader, playback, [](const Refresh& r) { return r.is_over; });
    expect_calm(after);
    EXPECT_GE(after.front().time_s, stalled_at_s);
    EXPECT_EQ(shown_, pictures - 1);
    EXPECT_TRUE(std::ranges::any_of(after, [](const Refresh& r) {
        return r.shown > pictures / 2 && r.shown < pictures - 1;
    })) << "what came after the stall is played, not cut to its end";
    std::set<std::int64_t> shown;
    for (const auto& seen : {before, after})
        for (const Refresh& refresh : seen)
            if (refresh.shown >= 0)
                shown.insert(refresh.shown);
    EXPECT_EQ(playback.counts().lost, 0);
    EXPECT_EQ(std::int64_t(shown.size()) + playback.counts().skipped, pictures - *shown.begin());
    EXPECT_GT(playback.jitter_s(), 0) << "of a server that fell silent";
}

/// Where it is by now: ahead of the play-out delay by up to what is asked for, through the stall and after it, never
/// back; what is seen later is later.
TEST_F(LivePlayback, WhatMovesIsWhereItIsByNow) {
    constexpr double max_ahead_s = 0.1;
    PacedServer server;
    server.give(parts, 0, pictures / 2);
    FrameLoader loader(server.address(), {});
    Playback playback(loader);
    std::vector<double> now_s, at_s, ahead_s;
    const auto note = [&](const Refresh& r) {
        if (r.shown < 0)
            return;
        const double extrapolation_s = playback.extrapolation_s(max_ahead_s);
        now_s.push_back(r.now_s);
        at_s.push_back(double(r.shown) / 30 + extrapolation_s);
        ahead_s.push_back(at_s.back() - r.time_s);
        EXPECT_GE(extrapolation_s, 0);
        EXPECT_LE(ahead_s.back(), max_ahead_s + 1e-6);
        EXPECT_GE(playback.extrapolation_s(max_ahead_s, 0.02), extrapolation_s);
        EXPECT_NEAR(playback.extrapolation_s(0), extrapolation_s - ahead_s.back(), 1e-6)
            << "at least at the clock's own time";
    };
    watch_live(loader, playback, [&](const Refresh& r) { return note(r), r.state == ClockState::stalled; });
    EXPECT_NEAR(ahead_s.back(), max_ahead_s, 1e-6) << "as far ahead as it may be, once nothing comes";
    server.give(parts, pictures / 2, pictures);
    server.close();
    watch_live(loader, playback, [&](const Refresh& r) { return note(r), r.is_over; });
    EXPECT_GT(*std::ranges::max_element(ahead_s), 0.05);
    const MediaClockOptions clock;
    for (std::size_t i = 1; i < at_s.size(); ++i) {
        const double elapsed_s = now_s[i] - now_s[i - 1];
        ASSERT_GE(at_s[i], at_s[i - 1] - 1e-6) << i;
        if (elapsed_s < clock.pause_s) {
            ASSERT_LE(at_s[i] - at_s[i - 1], clock.max_rate * elapsed_s + 0.01) << i;
        }
    }
}

/// While half of a stream comes.
class PausedLivePlayback : public LivePlayback {
protected:
    PausedLivePlayback() {
        server.give(parts, 0, pictures / 2);
        loader.emplace(server.address(), FeedOptions{});
        playback.emplace(*loader);
        watch([](const Refresh& r) { return r.shown > 0; });
        playback->pause();
        paused_at = shown_;
    }
    void watch(const std::function<bool(const Refresh&)>& until) { watch_live(*loader, *playback, until); }

    PacedServer server;
    std::optional<FrameLoader> loader;
    std::optional<Playback> playback;
    std::int64_t paused_at = -1;
};

TEST_F(PausedLivePlayback, StopsThePictureAndNotTheStream) {
    server.give(parts, pictures / 2, pictures);
    server.close();
    watch([&](const Refresh&) { return loader->state().ended; });
    EXPECT_EQ(shown_, paused_at);
    playback->play();
    watch([](const Refresh& r) { return r.is_over; });
    EXPECT_EQ(shown_, pictures - 1);
}

TEST_F(LivePlayback, AServerThatHasSentAllIsLeft) {
    PacedServer server;
    server.give(parts, 0, pictures);
    FrameLoader loader(server.address(), {.poses = &poses});
    Playback playback(loader);
    watch_live(loader, playback, [](const Refresh& r) { return r.shown > 0; });
    server.end();
    EXPECT_TRUE(server.is_left());
    watch_live(loader, playback, [](const Refresh& r) { return r.is_over; });
    EXPECT_EQ(shown_, pictures - 1);
    // Nothing is overdue where nothing is to come, paused or not.
    playback.pause();
    playback.refresh(loader.now_s() + 30);
    EXPECT_EQ(playback.overdue_s(), 0);
}

TEST_F(PausedLivePlayback, KeepsThePictureWhenTheServerBeginsAnew) {
    const auto first_reel = loader->state().reel;
    server.close();
    watch([&](const Refresh&) { return playback->attempts() > 0; });
    server.give(parts, 0, pictures);
    server.close();
    watch([&](const Refresh&) { return loader->state().ended; });
    EXPECT_NE(loader->state().reel, first_reel);
    EXPECT_EQ(shown_, paused_at);
}

/// Who reads is never made to wait then, and has to be asked to end all the same.
TEST_F(LivePlayback, ANoiseWithoutEndIsLeft) {
    PacedServer server;
    server.give(parts, 0, pictures / 2);
    std::vector<char> noise(1 << 16);
    for (std::size_t i = 0; i < noise.size(); ++i)
        noise[i] = char((i * 2654435761U) >> 13);
    server.flood(noise);
    const auto start = Clock::now();
    {
        FrameLoader loader(server.address(), {.poses = &poses});
        for (int i = 0; i < 1000; ++i)
            doze();
        EXPECT_FALSE(loader.state().ended);
    }
    EXPECT_LT(seconds_since(start), 15);
}

/// After ten seconds; the paths of a network may have vanished without a word.
TEST_F(LivePlayback, AServerThatFallsSilentIsAskedAgain) {
    PacedServer server;
    server.give(parts, 0, pictures / 2);
    FrameLoader loader(server.address(), {});
    Playback playback(loader);
    const auto start = Clock::now();
    watch_live(loader, playback, [&](const Refresh&) { return playback.attempts() > 0; });
    EXPECT_GT(seconds_since(start), 9);
    EXPECT_FALSE(loader.state().ended);
    server.close();
    server.give(parts, 0, pictures);
    server.close();
    watch_live(loader, playback, [](const Refresh& r) { return r.is_over; });
    EXPECT_EQ(shown_, pictures - 1);
}

TEST_F(LivePlayback, AServerThatIsLostIsAskedAgain) {
    PacedServer server;
    server.give(parts, 0, pictures / 2);
    server.close();
    FrameLoader loader(server.address(), {});
    Playback playback(loader);
    watch_live(loader, playback, [&](const Refresh&) { return playback.attempts() > 1; });
    ASSERT_GE(shown_, 0);
    const std::int64_t lost_at = shown_;
    EXPECT_LT(lost_at, pictures / 2);
    EXPECT_FALSE(loader.state().ended);
    // It begins anew, with frames that were seen: a reel of their own.
    const auto lost_reel = loader.state().reel;
    server.give(parts, 0, pictures);
    server.close();
    const auto seen = watch_live(loader, playback, [](const Refresh& r) { return r.is_over; });
    EXPECT_NE(loader.state().reel, lost_reel);
    EXPECT_EQ(playback.attempts(), 0);
    EXPECT_EQ(shown_, pictures - 1);
    EXPECT_TRUE(std::ranges::any_of(seen, [](const Refresh& r) { return r.shown == 0; }));
}

/// A recording that was cut when it was made is not asked for over and over.
TEST_F(LivePlayback, AStreamThatIsCutTwiceInTheSamePlaceHasEnded) {
    PacedServer server;
    for (int time = 0; time < 2; ++time) {
        server.give(parts, 0, pictures / 2);
        server.close();
    }
    FrameLoader loader(server.address(), {});
    Playback playback(loader);
    watch_live(loader, playback, [](const Refresh& r) { return r.is_over; });
    EXPECT_TRUE(loader.state().ended);
    EXPECT_EQ(loader.figures().reconnections, 1);
    EXPECT_NE(loader.truncation(), "");
}

/// A server leaves out what its viewer has no time for: that is no loss.
TEST_F(LivePlayback, AStreamWithoutSomeGroupsEndsAsAnyOther) {
    std::vector<char> bytes;
    for (const std::vector<char>& part : parts)
        bytes.insert(bytes.end(), part.begin(), part.end());
    constexpr std::array<char, 4> cluster = {0x1f, 0x43, char(0xb6), 0x75};
    const auto cluster_after = [&](std::vector<char>::iterator from) {
        return std::search(from, bytes.end(), cluster.begin(), cluster.end());
    };
    const auto second = cluster_after(cluster_after(bytes.begin()) + 1), third = cluster_after(second + 1);
    ASSERT_NE(third, bytes.end());
    bytes.erase(second, third);
    PacedServer server;
    server.give({bytes}, 0, 1);
    server.end();
    FrameLoader loader(server.address(), {});
    Playback playback(loader);
    watch_live(loader, playback, [](const Refresh& r) { return r.is_over; });
    EXPECT_EQ(loader.figures().reconnections, 0);
    EXPECT_EQ(loader.truncation(), "");
    EXPECT_EQ(shown_, pictures - 1);
    EXPECT_LT(loader.figures().frames, pictures);
}

}  // namespace
}  // namespace equistream::test
