/// When bytes are due, against what the pictures are and when they are shown.
#include "synthetic.h"

#include <equistream/error.h>
#include <equistream/send_times.h>
#include <equistream/viewer_message.h>

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <random>

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
    const std::int64_t all = coded.bytes_of(made.pictures, made.first_index);
    for (int frame = 0; frame < made.pictures; ++frame) {
        const std::int64_t due = coded.due_at(frame / 30.0 + clock_s);
        EXPECT_GE(due, coded.bytes_of(frame + 1, made.first_index)) << frame;
        const std::int64_t later = all - coded.bytes_of(frame + 1 + max_reordered, made.first_index);
        EXPECT_LE(due, coded.file_bytes - later) << frame;
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
    for (int frame = 0; frame < made.pictures; ++frame)
        EXPECT_GE(coded.due_at(frame / 30.0 + clock_s), coded.bytes_of(frame + 1, made.first_index)) << frame;
    const std::int64_t later = coded.bytes_of(made.pictures, 5) - coded.bytes_of(made.settings.gop, made.first_index);
    EXPECT_LE(coded.due_at((made.settings.gop - 1) / 30.0 + clock_s), coded.file_bytes - later);
}

TEST(SendTimes, NothingElseHasTimes) {
    const synthetic::Folder folder;
    std::ofstream(folder / "notes.mkv") << "nothing to see\n";
    EXPECT_THROW(read_send_times((folder / "notes.mkv").string()), InputError);
    EXPECT_THROW(read_send_times((folder / "absent.mkv").string()), InputError);
}

}  // namespace

// Messages from viewers: what is a pose comes out, everything else is passed over.

namespace {

using Bytes = std::vector<std::uint8_t>;

ViewerPose some_pose(double x) {
    return {1.25, {{x, 2, -3e8}, glm::dquat(0.5, -0.5, 0.5, 0.5)}};
}

template <typename T>
void put(Bytes& bytes, std::size_t offset, T value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
}

void append(Bytes& bytes, const Bytes& more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
}

void expect_pose(const std::optional<ViewerPose>& found, const ViewerPose& expected) {
    ASSERT_TRUE(found);
    EXPECT_EQ(found->time_s, expected.time_s);
    EXPECT_EQ(found->head.position_m, expected.head.position_m);
    EXPECT_EQ(found->head.orientation, expected.head.orientation);
}

TEST(ViewerMessage, LiesInMemoryAsTheTableSays) {
    const Bytes bytes = encode_viewer_pose(some_pose(7));
    ASSERT_EQ(bytes.size(), 76u);
    const Bytes header = {'E', 'Q', 'V', 'M', 1, 0, 1, 0, 64, 0, 0, 0};
    EXPECT_TRUE(std::equal(header.begin(), header.end(), bytes.begin()));
    const double fields[] = {1.25, 7, 2, -3e8, 0.5, -0.5, 0.5, 0.5};
    EXPECT_EQ(std::memcmp(bytes.data() + 12, fields, sizeof fields), 0);
}

TEST(ViewerMessage, ComesOutOfPiecesOfAnySize) {
    Bytes bytes;
    for (int i = 0; i < 5; ++i)
        append(bytes, encode_viewer_pose(some_pose(i)));
    for (const std::size_t piece : {1u, 2u, 7u, 76u, 77u, 1000u}) {
        ViewerMessageReader reader;
        std::optional<ViewerPose> last;
        for (std::size_t at = 0; at < bytes.size(); at += piece)
            if (const auto pose = reader.take(std::span(bytes).subspan(at, std::min(piece, bytes.size() - at))))
                last = pose;
        expect_pose(last, some_pose(4));
    }
}

TEST(ViewerMessage, NoNumberThatIsNonePasses) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    struct Change {
        std::size_t field;
        double value;
    };
    for (const Change& change :
         {Change{0, nan}, {1, nan}, {2, inf}, {3, -2e9}, {3, 1e9}, {4, nan}, {4, 0.6}, {5, 0.5001}}) {
        Bytes bytes = encode_viewer_pose(some_pose(1));
        put(bytes, 12 + 8 * change.field, change.value);
        ViewerMessageReader reader;
        EXPECT_FALSE(reader.take(bytes)) << change.field << " " << change.value;
        expect_pose(reader.take(encode_viewer_pose(some_pose(2))), some_pose(2));
    }
}

TEST(ViewerMessage, OtherKindsAndVersionsArePassedOverWhole) {
    for (const std::size_t offset : {4u, 6u}) {
        Bytes other = encode_viewer_pose(some_pose(1));
        put(other, offset, std::uint16_t(2));
        put(other, 8, std::uint32_t(200));
        Bytes inside(136, 0);
        const Bytes pose = encode_viewer_pose(some_pose(3));  // is no message of its own
        std::copy(pose.begin(), pose.end(), inside.begin());
        append(other, inside);
        ViewerMessageReader reader;
        EXPECT_FALSE(reader.take(other));
        expect_pose(reader.take(encode_viewer_pose(some_pose(2))), some_pose(2));
    }
}

TEST(ViewerMessage, FieldsThatAreAppendedAreSkippedAndShortOnesRefused) {
    Bytes longer = encode_viewer_pose(some_pose(1));
    put(longer, 8, std::uint32_t(72));
    append(longer, Bytes(8, 0xff));
    append(longer, encode_viewer_pose(some_pose(2)));
    expect_pose(ViewerMessageReader().take(longer), some_pose(2));
    Bytes shorter = encode_viewer_pose(some_pose(1));
    put(shorter, 8, std::uint32_t(56));
    EXPECT_FALSE(ViewerMessageReader().take(shorter));
}

TEST(ViewerMessage, GarbageAndLengthsBeyondAllBoundsAreSearchedForTheNextOne) {
    std::mt19937 random(7);
    ViewerMessageReader reader;
    for (int round = 0; round < 200; ++round) {
        Bytes bytes(random() % 3000);
        for (std::uint8_t& byte : bytes)
            byte = std::uint8_t(random());
        append(bytes, {'E', 'Q', 'V', 'M', 1, 0, 1, 0, 0xff, 0xff, 0xff, 0xff});
        append(bytes, {'E', 'Q', 'V'});
        append(bytes, encode_viewer_pose(some_pose(round)));
        expect_pose(reader.take(bytes), some_pose(round));
    }
}

}  // namespace
}  // namespace equistream
