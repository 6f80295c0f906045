/// When bytes are due, against what the pictures are and when they are shown.
#include "synthetic.h"

#include <equistream/error.h>
#include <equistream/send_times.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <vector>

namespace equistream {
namespace {

struct Coded {
    SendTimes times;
    std::vector<DecodedPicture> pictures;
    std::int64_t file_bytes;

    explicit Coded(const std::filesystem::path& file)
        : times(read_send_times(file.string())), file_bytes(std::int64_t(std::filesystem::file_size(file))) {
        StreamReader reader(file.string());
        pictures = synthetic::read_all(reader);
    }
    std::int64_t due_at(double time_s) const {
        std::int64_t bytes = 0;
        for (const DueBytes& part : times.parts)
            if (part.time_s <= time_s)
                bytes = part.end;
        return bytes;
    }
    /// Coded bytes of the pictures of the first `count` frames.
    std::int64_t bytes_of(std::int64_t count, std::int64_t first_index) const {
        std::int64_t bytes = 0;
        for (const DecodedPicture& picture : pictures)
            bytes += picture.info->index < first_index + count ? picture.bytes : 0;
        return bytes;
    }
};

/// Containers' own clocks count whole milliseconds or finer.
constexpr double clock_s = 1e-3;

/// Pictures are coded at most so many before others that are shown earlier: three between references, and these.
constexpr int max_reordered = 4;

TEST(SendTimes, OfMatroskaEachFramesBytesAreDueAtItsTimeAndNoLaterOnes) {
    const synthetic::Folder folder;
    const synthetic::Made made = synthetic::small_stream(Codec::h264, true);
    synthetic::write(folder / "a.mkv", made);
    const Coded coded(folder / "a.mkv");
    EXPECT_TRUE(coded.times.is_matroska);
    EXPECT_EQ(coded.times.parts.front().time_s, 0);
    EXPECT_GE(coded.times.parts.back().time_s, (made.pictures - 1 - max_reordered) / 30.0 - clock_s);
    for (std::size_t i = 1; i < coded.times.parts.size(); ++i) {
        EXPECT_GT(coded.times.parts[i].time_s, coded.times.parts[i - 1].time_s);
        EXPECT_GT(coded.times.parts[i].end, coded.times.parts[i - 1].end);
    }
    EXPECT_EQ(coded.times.parts.back().end, coded.file_bytes);
    EXPECT_NEAR(coded.times.duration_s, made.pictures / 30.0, 2 * clock_s);
    EXPECT_NEAR(coded.times.longest_track_s, (made.pictures - 1) / 30.0, 2 * clock_s);
    const std::int64_t all = coded.bytes_of(made.pictures, made.first_index);
    for (int frame = 0; frame < made.pictures; ++frame) {
        const std::int64_t due = coded.due_at(frame / 30.0 + clock_s);
        EXPECT_GE(due, coded.bytes_of(frame + 1, made.first_index)) << frame;
        const std::int64_t later = all - coded.bytes_of(frame + 1 + max_reordered, made.first_index);
        EXPECT_LE(due, coded.file_bytes - later) << frame;
    }
}

std::vector<Moment> groups_of(const SendTimes& times) {
    std::vector<Moment> groups;
    std::ranges::copy_if(times.moments, std::back_inserter(groups), &Moment::begins_group);
    return groups;
}

TEST(SendTimes, OfMatroskaGroupsBeginWhereAllTracksCanBeDecodedFrom) {
    for (const Codec codec : {Codec::h264, Codec::h265}) {
        const synthetic::Folder folder;
        synthetic::Made made = synthetic::small_stream(codec, true);
        made.settings.gop = 5;
        made.settings.preset = "medium";  // reorders pictures
        made.settings.pictures = 23;
        made.pictures = 23;
        synthetic::write(folder / "a.mkv", made);
        const SendTimes times = read_send_times((folder / "a.mkv").string());
        const std::vector<Moment> groups = groups_of(times);
        ASSERT_EQ(groups.size(), 4u);
        for (std::size_t i = 0; i < 4; ++i)
            EXPECT_NEAR(groups[i].time_s, double(i + 1) * 5 / 30, clock_s);
        EXPECT_EQ(newest_group(times.moments, 0.1), nullptr);
        EXPECT_EQ(newest_group(times.moments, 0.4)->start, groups[1].start);
        EXPECT_EQ(newest_group(times.moments, 100)->start, groups[3].start);
        synthetic::write(folder / "a.mp4", made);
        EXPECT_TRUE(read_send_times((folder / "a.mp4").string()).moments.empty());
    }
}

/// A group's samples lie there one track behind the other: what is in front of a sample is due when it is.
TEST(SendTimes, OfMp4NoFrameComesLateAndGroupsAfterEachOther) {
    const synthetic::Folder folder;
    const synthetic::Made made = synthetic::small_stream(Codec::h264, true);
    synthetic::write(folder / "a.mp4", made);
    const Coded coded(folder / "a.mp4");
    EXPECT_FALSE(coded.times.is_matroska);
    EXPECT_EQ(coded.times.parts.front().time_s, 0);
    EXPECT_EQ(coded.times.parts.back().end, coded.file_bytes);
    EXPECT_NEAR(coded.times.longest_track_s, (made.pictures - 1) / 30.0, 2 * clock_s);
    for (int frame = 0; frame < made.pictures; ++frame)
        EXPECT_GE(coded.due_at(frame / 30.0 + clock_s), coded.bytes_of(frame + 1, made.first_index)) << frame;
    const std::int64_t later = coded.bytes_of(made.pictures, 5) - coded.bytes_of(made.settings.gop, made.first_index);
    EXPECT_LE(coded.due_at((made.settings.gop - 1) / 30.0 + clock_s), coded.file_bytes - later);
}

/// Where an MP4 is cut within a group, all pictures that play count.
TEST(SendTimes, OfACutMp4AreOfAllThatPlays) {
    const synthetic::Folder folder;
    synthetic::write(folder / "whole.mp4", synthetic::small_stream(Codec::h264, true));
    const auto bytes = std::filesystem::file_size(folder / "whole.mp4");
    const std::filesystem::path file = folder / "a.mp4";
    int tried = 0;
    for (int part = 30; part < 60; ++part) {
        std::filesystem::copy_file(folder / "whole.mp4", file, std::filesystem::copy_options::overwrite_existing);
        std::filesystem::resize_file(file, bytes * std::uintmax_t(part) / 60);
        std::map<TrackRole, int> count;
        try {
            StreamReader reader(file.string());
            for (const DecodedPicture& picture : synthetic::read_all(reader))
                ++count[picture.role];
        } catch (const InputError&) {
            continue;  // cut within the header
        }
        if (count[TrackRole::main] == 0)
            continue;
        ++tried;
        EXPECT_GE(read_send_times(file.string()).longest_track_s, (count[TrackRole::main] - 1) / 30.0 - 2 * clock_s)
            << part;
    }
    EXPECT_GT(tried, 5);
}

TEST(SendTimes, NothingElseHasTimes) {
    const synthetic::Folder folder;
    std::ofstream(folder / "notes.mkv") << "nothing to see\n";
    EXPECT_THROW(read_send_times((folder / "notes.mkv").string()), InputError);
    EXPECT_THROW(read_send_times((folder / "absent.mkv").string()), InputError);
}

}  // namespace
}  // namespace equistream
