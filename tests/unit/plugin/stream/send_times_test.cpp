/// When bytes are due, against what the pictures are and when they are shown; which of a recording's tiles are sent,
/// and what viewers say of where they look.
#include "synthetic.h"

#include <equistream/error.h>
#include <equistream/send_times.h>
#include <equistream/tile_stream.h>
#include <equistream/viewer_message.h>

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <tuple>

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
    EXPECT_NEAR(coded.times.longest_track_s, made.pictures / 30.0, 2 * clock_s);
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
    EXPECT_NEAR(coded.times.longest_track_s, made.pictures / 30.0, 2 * clock_s);
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

TEST(ViewerMessage, SaysWhatIsShownWhereTheViewerDoes) {
    ViewerPose pose = some_pose(1);
    EXPECT_FALSE(ViewerMessageReader().take(encode_viewer_pose(pose))->view) << "as viewers before did";
    pose.view = {1.25, 0.75};
    const Bytes bytes = encode_viewer_pose(pose);
    ASSERT_EQ(bytes.size(), 92u);
    for (const std::size_t piece : {1u, 13u, 92u}) {
        ViewerMessageReader reader;
        std::optional<ViewerPose> found;
        for (std::size_t at = 0; at < bytes.size(); at += piece)
            found = reader.take(std::span(bytes).subspan(at, std::min(piece, bytes.size() - at)));
        expect_pose(found, pose);
        ASSERT_TRUE(found->view);
        EXPECT_EQ(found->view->half_width, 1.25);
        EXPECT_EQ(found->view->half_height, 0.75);
    }
    Bytes one = bytes;  // and only half of what is shown
    put(one, 8, std::uint32_t(72));
    one.resize(84);
    const auto found = ViewerMessageReader().take(one);
    expect_pose(found, pose);
    EXPECT_FALSE(found->view);
}

TEST(ViewerMessage, AViewThatIsNoneIsNotSaid) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const double half : {nan, inf, -inf, 0.0, -1.0, 1e-3, 58.0, 1e300, 5e-324})
        for (const bool of_height : {false, true}) {
            ViewerPose pose = some_pose(1);
            pose.view = {of_height ? 1 : half, of_height ? half : 1};
            const auto found = ViewerMessageReader().take(encode_viewer_pose(pose));
            expect_pose(found, pose);
            EXPECT_FALSE(found->view) << half;
        }
    for (const double half : {0.01, 57.0}) {
        ViewerPose pose = some_pose(1);
        pose.view = {half, half};
        EXPECT_TRUE(ViewerMessageReader().take(encode_viewer_pose(pose))->view) << half;
    }
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

// Of a recording's tiles, those that a viewer looks at.

namespace {

/// By track and index.
using Pictures = std::map<std::pair<std::size_t, std::int64_t>, ByteImage>;

Pictures pictures_of(const std::filesystem::path& file) {
    StreamReader reader(file.string());
    Pictures pictures;
    for (DecodedPicture& picture : synthetic::read_all(reader))
        pictures[{picture.track, picture.info.value().index}] = std::move(picture.rgb);
    return pictures;
}

/// What a viewer gets that looks at these tiles at each moment.
std::string sent(const TileRecording& recording, const std::function<std::set<int>(double)>& looked_at) {
    TileSender sender(recording);
    std::string bytes;
    double last_s = 0;
    while (const auto due_s = sender.due_s()) {
        EXPECT_GE(*due_s, last_s);
        last_s = *due_s;
        sender.next(looked_at(last_s), bytes);
    }
    return bytes;
}

/// 8x4 tiles; of each 24 pictures at 30 a second in groups of 10.
class Tiles : public testing::Test {
protected:
    void make(const std::string& name, const std::string& preset) {
        made_.preset = preset;
        synthetic::write(folder_ / name, made_);
    }
    Pictures played(const std::string& bytes) const {
        std::ofstream(folder_ / "sent.mkv", std::ios::binary) << bytes;
        return pictures_of(folder_ / "sent.mkv");
    }
    static std::size_t track_of(int tile) { return std::size_t(tile + 1); }

    synthetic::Folder folder_;
    synthetic::MadeTiles made_{.grid = {8, 4}, .pictures = 24, .gop = 10};
};

TEST_F(Tiles, AreFoundByTheirTracks) {
    for (const char* name : {"a.mkv", "a.mp4"}) {
        make(name, "ultrafast");
        const auto recording = open_tiles((folder_ / name).string());
        ASSERT_TRUE(recording);
        EXPECT_EQ(recording->grid, made_.grid);
        EXPECT_EQ(recording->first.index, made_.first_index);
        ASSERT_EQ(recording->tiles.size(), 33u);
        EXPECT_FALSE(recording->tiles.front());
        for (int tile = 0; tile < 32; ++tile)
            EXPECT_EQ(recording->tiles[track_of(tile)], tile);
        EXPECT_NEAR(recording->times.duration_s, 24 / 30.0, 2 * clock_s);
    }
    synthetic::write(folder_ / "none.mkv", synthetic::small_stream(Codec::h264, true));
    EXPECT_FALSE(open_tiles((folder_ / "none.mkv").string()));
    EXPECT_THROW(open_tiles((folder_ / "absent.mkv").string()), InputError);
}

TEST_F(Tiles, OfNoGridAreBadInput) {
    const auto expect_refused = [&](const std::vector<Camera>& windows, const std::string& why) {
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.tracks.assign(windows.size() + 1, {TrackRole::window, 64, 64});
        settings.tracks.front() = {TrackRole::main, 128, 64};
        StreamWriter writer((folder_ / "a.mkv").string(), settings);
        writer.write(TrackRole::main, ByteImage(128, 64, 3).view(), synthetic::info(128, 64, 0));
        for (std::size_t i = 0; i < windows.size(); ++i) {
            FrameInfo info = synthetic::info(64, 64, 0);
            info.camera = windows[i];
            writer.write(TrackRole::window, ByteImage(64, 64, 3).view(), info, i);
        }
        writer.finish();
        try {
            open_tiles((folder_ / "a.mkv").string());
            ADD_FAILURE() << why;
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()),
                      (folder_ / "a.mkv").string() + ": expected tiles that are the parts of one sphere, found " + why);
        }
    };
    const WindowGrid grid{512, 256, 64, 64}, other{256, 128, 64, 64};
    const Camera first = window_camera(grid, {64, 0});
    expect_refused({first, window_camera(grid, {80, 0})}, "one of 64x64 that is none");
    expect_refused({first, window_camera(grid, {64, 16})}, "one of 64x64 that is none");
    expect_refused({first, window_camera(other, {64, 0})}, "tiles of other sizes");
    expect_refused({first, EquirectCamera{64, 64, {-0.3, 0.3, -0.3, 0.3}}}, "one of 64x64 that is none");
    expect_refused({first, EquirectCamera{64, 64, {}}}, "one of 64x64 that is none");
    expect_refused({first, EquirectCamera{64, 64, {0, 0.001, 0, 0.001}}}, "one of 64x64 that is none");
    expect_refused({first, PerspectiveCamera{64, 64, 1}}, "a flat view");
    expect_refused({PerspectiveCamera{64, 64, 1}, PerspectiveCamera{64, 64, 1}}, "a flat view");
}

TEST_F(Tiles, ThatAreNotLookedAtAreSentOnce) {
    for (const auto& [name, preset, first_moment] : {std::tuple("a.mkv", "ultrafast", 1),
                                                     {"a.mkv", "veryfast", max_reordered},
                                                     {"a.mp4", "ultrafast", 1},
                                                     {"a.mp4", "veryfast", max_reordered}}) {
        SCOPED_TRACE(std::string(name) + ", " + preset);
        make(name, preset);
        const Pictures whole = pictures_of(folder_ / name);
        const auto recording = open_tiles((folder_ / name).string());
        const std::string all = sent(*recording, [&](double) { return std::set{9, 10}; });
        std::map<std::size_t, int> counts;
        for (const auto& [key, picture] : played(all)) {
            EXPECT_TRUE(std::ranges::equal(picture.samples(), whole.at(key).samples())) << key.first;
            ++counts[key.first];
        }
        for (std::size_t track = 0; track < 33; ++track) {
            const bool looked_at = track == 0 || track == track_of(9) || track == track_of(10);
            EXPECT_GE(counts[track], looked_at ? 24 : 1) << track;
            EXPECT_LE(counts[track], looked_at ? 24 : first_moment) << track;
        }
        EXPECT_LT(all.size(), std::filesystem::file_size(folder_ / name) * 3 / 5);
    }
}

TEST_F(Tiles, ThatComeIntoViewBeginWithTheirKeyFrame) {
    for (const auto& [name, preset] : {std::pair("a.mkv", "ultrafast"), {"a.mkv", "veryfast"}, {"a.mp4", "veryfast"}}) {
        SCOPED_TRACE(std::string(name) + ", " + preset);
        make(name, preset);
        const Pictures whole = pictures_of(folder_ / name);
        const auto recording = open_tiles((folder_ / name).string());
        // From the sixth picture of the second group on at another one, for some time.
        const auto pictures = played(sent(*recording, [&](double time_s) {
            const double picture = time_s * 30 + 0.5;
            return picture < 15 ? std::set{3} : picture < 18 ? std::set{20} : std::set{3, 7};
        }));
        for (const auto& [key, picture] : pictures)
            EXPECT_TRUE(std::ranges::equal(picture.samples(), whole.at(key).samples()))
                << key.first << ", " << key.second;
        const auto has = [&](int tile, int ordinal) {
            return pictures.contains({track_of(tile), made_.first_index + ordinal});
        };
        for (int ordinal = 0; ordinal < 24; ++ordinal) {
            EXPECT_TRUE(has(3, ordinal)) << ordinal << ": what was let go by is made up for, within its group";
            const bool begins = ordinal > max_reordered && ordinal < 10, late = ordinal >= 20 + max_reordered;
            EXPECT_FALSE((begins || late) && has(20, ordinal)) << ordinal;
            EXPECT_FALSE(begins && has(7, ordinal)) << ordinal;
            EXPECT_TRUE(ordinal < 10 || ordinal >= 18 - max_reordered || has(20, ordinal)) << ordinal;
            EXPECT_TRUE(ordinal < 10 || has(7, ordinal)) << ordinal << ": from the key frame on";
        }
    }
}

}  // namespace
}  // namespace equistream
