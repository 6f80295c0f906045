/// How far ahead and how far back frames are read, and which of those that never come count as lost.
#include "frames_folder.h"
#include "paced_server.h"

#include <client/playback/playback.h>
#include <tests/support/gapped_stream.h>

#include <equistream/stream.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace equistream::test {
namespace {

class LoadedFrames : public FramesFolder {
protected:
    /// What a jump or a step leads to; -1: nothing came of it within 20 s.
    static std::int64_t arrive(Playback& playback) {
        double now_s = 0;
        std::int64_t shown = -1;
        for (int i = 0; i < 20000; ++i, now_s += 0.01, doze()) {
            if (const SharedFrame frame = playback.refresh(now_s).frame)
                shown = frame->main.info.index;
            if (!playback.is_moving())
                return shown;
        }
        return -1;
    }
    /// The last one shown.
    static std::int64_t play_all(Playback& playback) {
        std::int64_t shown = -1;
        double now_s = 0;
        for (int i = 0; i < 20000; ++i, now_s += 0.01, doze()) {
            const Playback::Moment moment = playback.refresh(now_s);
            if (moment.frame)
                shown = moment.frame->main.info.index;
            if (moment.is_over)
                return shown;
        }
        return -1;
    }
};

TEST_F(LoadedFrames, ReadAsFarAheadAsMemoryAllows) {
    constexpr std::size_t frame_bytes = 32 * 16 * 3;
    constexpr int frames = 30;
    write_frames(range(0, frames - 1), 1000);
    for (const auto& [max_bytes, expected] :
         {std::pair{std::size_t{1}, 3}, {10 * frame_bytes, 10}, {1000 * frame_bytes, frames}}) {
        FrameLoader loader(folder.string(), {}, max_bytes);
        for (int i = 0; i < 20000 && loader.figures().frames < expected; ++i)
            doze();
        for (int i = 0; i < 30; ++i)  // in which more might come
            doze();
        EXPECT_EQ(loader.figures().frames, expected);
    }
}

/// Dense frames, and then few: no more are read again than the gap is wide.
TEST_F(LoadedFrames, ASearchBackReadsLittleOfWhatIsDense) {
    constexpr std::int64_t last_dense = 99, after_gap = 120;
    std::vector<std::int64_t> numbers = range(0, last_dense);
    numbers.push_back(after_gap);
    write_frames(numbers, 30);
    std::atomic<int> reads = 0;
    FrameLoader loader(folder.string(), {.left_out = [&] { return ++reads, TrackRoles{}; }});
    Playback playback(loader, true);
    playback.seek(double(after_gap) * interval_s);
    ASSERT_EQ(arrive(playback), after_gap);
    reads = 0;
    playback.seek_back(double(after_gap - 1) * interval_s);
    EXPECT_EQ(arrive(playback), last_dense);
    EXPECT_LT(reads.load(), 30);
}

/// It has gone: to open it anew would fail.
TEST_F(LoadedFrames, BackFromTheFirstFrameOpensNothingAnew) {
    const std::filesystem::path file = folder / "first.mkv";
    {
        std::ofstream out(file, std::ios::binary);
        for (const std::vector<char>& part : coded(12))
            out.write(part.data(), std::streamsize(part.size()));
    }
    FrameLoader loader(file.string(), {});
    Playback playback(loader, true);
    ASSERT_EQ(arrive(playback), 0);
    std::filesystem::remove(file);
    for (int press = 0; press < 2; ++press) {
        playback.seek_back(-interval_s);
        EXPECT_EQ(arrive(playback), 0);
    }
}

/// A live scene's stream in parts: its header, its pictures, each a key frame, and its end. Only every third frame was
/// rendered.
std::vector<std::string> live_parts(int pictures) {
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.live = true;
    settings.tracks = {{TrackRole::main, 128, 64}};
    std::vector<std::string> parts(1);
    const auto take = [&](std::span<const std::uint8_t> bytes) { parts.back().append(bytes.begin(), bytes.end()); };
    StreamWriter writer("live.mkv", settings, StreamTap{take, true});
    for (int i = 0; i < pictures; ++i) {
        parts.emplace_back();
        FrameInfo info;
        info.index = 3 * i;
        info.time_s = double(info.index) / settings.frames_per_second;
        info.camera = EquirectCamera{128, 64, {}};
        writer.begin_group();
        writer.write(TrackRole::main, ByteImage(128, 64, 3, std::uint8_t(10 * i)).view(), info);
        writer.flush();
    }
    parts.emplace_back();
    writer.finish();
    return parts;
}

TEST_F(LoadedFrames, WhatWasSentAndDidNotComeIsLost) {
    const std::vector<std::string> parts = live_parts(12);
    for (const std::set<std::size_t>& missing : {std::set<std::size_t>{}, {4, 7, 8}}) {
        const std::filesystem::path file = folder / "live.mkv";
        {
            std::ofstream out(file, std::ios::binary);
            for (std::size_t i = 0; i < parts.size(); ++i)
                if (!missing.contains(i))
                    out << parts[i];
        }
        FrameLoader loader(file.string(), {});
        Playback playback(loader);
        EXPECT_EQ(play_all(playback), 34) << "the last one, which the stream's end repeats";
        EXPECT_EQ(playback.counts().lost, std::ssize(missing));
    }
}

/// Neither of ordinary video, whose rate may vary, nor of posed frames are gaps between their numbers lost frames.
TEST_F(LoadedFrames, NoFrameIsLostThatWasNeverSent) {
    for (const bool posed : {false, true}) {
        const std::filesystem::path file = folder / (posed ? "posed.mkv" : "ordinary.mkv");
        testing::write_gapped_stream(file.string(), posed);
        FrameLoader loader(file.string(), {});
        ASSERT_EQ(loader.is_posed(), posed);
        Playback playback(loader);
        ASSERT_EQ(play_all(playback), 185);
        EXPECT_EQ(playback.counts().lost, 0);
    }
}

}  // namespace
}  // namespace equistream::test
