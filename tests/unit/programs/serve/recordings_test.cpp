/// What viewers of a recorded stream are sent who keep up, and who do not.
#include <equistream/error.h>
#include <equistream/viewer_message.h>
#include <programs/serve/programmes.h>
#include <programs/serve/recorded_file.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace equistream::serve {
namespace {

/// Everything that a viewer gets who asks in time; how long it took, and the longest silence. Clients give up a server
/// that says nothing for 10 s.
struct Watched {
    std::string bytes;
    double seconds = 0, longest_silence_s = 0;
};

Watched watched(Programme& programme) {
    const auto feed = programme.open_feed();
    std::array<char, 1 << 16> block;
    Watched watched;
    double last_sent_s = 0;
    for (;;) {
        const Portion portion = feed->next(block, watched.seconds);
        EXPECT_EQ(portion.problem, "");
        if (portion.ended || !portion.problem.empty())
            return watched;
        watched.bytes.append(block.data(), portion.bytes);
        if (portion.bytes > 0) {
            watched.longest_silence_s = std::max(watched.longest_silence_s, watched.seconds - last_sent_s);
            last_sent_s = watched.seconds;
        }
        watched.seconds = portion.again_s.value_or(watched.seconds);
    }
}

TEST(Recordings, SaySomethingEverySecond) {
    const synthetic::Folder folder;
    const synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    StreamSettings settings = made.settings;
    settings.frames_per_second = 0.05;
    const std::filesystem::path file = folder / "slow.mkv";
    {
        StreamWriter writer(file.string(), settings);
        for (std::int64_t index = 0; index < made.pictures; ++index) {
            FrameInfo info = synthetic::info(192, 96, index);
            info.frames_per_second = 0.05;
            info.time_s = 20 * double(index);
            writer.write(TrackRole::main, synthetic::picture(192, 96, index).view(), info);
        }
        writer.finish();
    }
    const auto programme = open_recording(file.string(), false);
    const Watched found = watched(*programme);
    EXPECT_LE(found.longest_silence_s, 1.001);
    EXPECT_GE(found.seconds, 20 * (made.pictures - 1)) << "no picture comes before its time";
    std::ifstream whole(file, std::ios::binary);
    EXPECT_TRUE(found.bytes == std::string(std::istreambuf_iterator<char>(whole), {}));
}

TEST(TiledRecordings, SaySomethingEverySecond) {
    const synthetic::Folder folder;
    const synthetic::MadeTiles made{.pictures = 4, .first_index = 0, .frames_per_second = 0.05};
    synthetic::write(folder / "slow.mkv", made);
    const auto programme = open_recording((folder / "slow.mkv").string(), false);
    const Watched found = watched(*programme);
    EXPECT_LE(found.longest_silence_s, 1.001);
    EXPECT_GE(found.seconds, 20 * (made.pictures - 1));
    std::ofstream(folder / "sent.mkv", std::ios::binary) << found.bytes;
    StreamReader reader((folder / "sent.mkv").string());
    int main = 0;
    while (const auto picture = reader.next())
        main += picture->role == TrackRole::main;
    EXPECT_EQ(main, made.pictures);
}

/// What a viewer gets by a line that carries `bytes_per_second`, who asks for bytes `behind_s` later than they are due.
struct Carried {
    std::map<std::size_t, std::vector<std::int64_t>> indices;  ///< of the pictures, by their tracks
    double longest_behind_s = 0;
    std::size_t bytes = 0;

    std::size_t pictures() const {
        std::size_t count = 0;
        for (const auto& [track, of_track] : indices)
            count += of_track.size();
        return count;
    }
};

constexpr double without_limit = std::numeric_limits<double>::infinity();

Carried carried(Programme& programme, const std::filesystem::path& file, double bytes_per_second, double behind_s = 0) {
    const auto feed = programme.open_feed();
    std::ofstream sent(file, std::ios::binary);
    std::array<char, 1 << 14> block;
    Carried carried;
    double elapsed_s = behind_s;
    for (;;) {
        const Portion portion = feed->next(block, elapsed_s);
        EXPECT_EQ(portion.problem, "");
        if (portion.ended || !portion.problem.empty())
            break;
        sent.write(block.data(), std::streamsize(portion.bytes));
        carried.bytes += portion.bytes;
        if (portion.bytes > 0)
            carried.longest_behind_s = std::max(carried.longest_behind_s, elapsed_s - portion.due_s);
        elapsed_s =
            portion.again_s ? *portion.again_s + behind_s : elapsed_s + double(portion.bytes) / bytes_per_second;
    }
    sent.close();
    StreamReader reader(file.string());
    while (const auto picture = reader.next())
        carried.indices[picture->track].push_back(picture->info->index);
    return carried;
}

/// All tracks from key frames on, without a picture that cannot be decoded.
void expect_last_of_groups(const Carried& found, std::int64_t first, std::int64_t end, int gop) {
    for (const auto& [track, indices] : found.indices) {
        EXPECT_EQ(indices.front(), first) << track;
        EXPECT_GE(indices.back(), end - gop) << track;
        EXPECT_LT(indices.size(), std::size_t(end - first) / 2) << track;
        for (std::size_t i = 1; i < indices.size(); ++i)
            EXPECT_TRUE(indices[i] == indices[i - 1] + 1 || (indices[i] - first) % gop == 0)
                << track << ": " << indices[i] << " after " << indices[i - 1];
    }
}

TEST(Recordings, SkipToTheNewestGroupForAViewerThatIsFarBehind) {
    const synthetic::Folder folder;
    synthetic::Made made = synthetic::small_stream(Codec::h264, true);
    made.settings.gop = 10;
    made.settings.pictures = 300;
    made.pictures = 300;
    synthetic::write(folder / "a.mkv", made);
    const auto programme = open_recording((folder / "a.mkv").string(), false);
    const auto whole = double(std::filesystem::file_size(folder / "a.mkv"));
    const Carried wide = carried(*programme, folder / "wide.mkv", whole);
    EXPECT_EQ(wide.bytes, std::size_t(whole));
    EXPECT_LT(wide.longest_behind_s, 0.5);
    const Carried narrow = carried(*programme, folder / "narrow.mkv", whole / 100);
    EXPECT_LT(narrow.bytes, std::size_t(whole / 5));
    EXPECT_LT(narrow.longest_behind_s, 2 + 100.0 / 30) << "and what a group takes";
    ASSERT_EQ(narrow.indices.size(), 2u);
    expect_last_of_groups(narrow, made.first_index, made.first_index + made.pictures, 10);
}

/// Key frames of both tracks are longer than a cluster, and each takes longer than a viewer may be behind.
TEST(Recordings, SkipBetweenMomentsSoThatNoTrackStarves) {
    const synthetic::Folder folder;
    StreamSettings settings = synthetic::small_stream(Codec::h264, true).settings;
    settings.gop = 10;
    settings.crf = 0;
    settings.pictures = 100;
    settings.tracks = {{TrackRole::main, 384, 192}, {TrackRole::small, 192, 192}};
    const std::filesystem::path file = folder / "a.mkv";
    {
        std::mt19937 random(1);
        StreamWriter writer(file.string(), settings);
        for (std::int64_t index = 0; index < settings.pictures; ++index)
            for (const TrackSettings& track : settings.tracks) {
                ByteImage noise(track.width, track.height, 3);
                std::ranges::generate(noise.samples(), [&] { return std::uint8_t(random()); });
                writer.write(track.role, noise.view(), synthetic::info(track.width, track.height, index));
            }
        writer.finish();
    }
    const auto programme = open_recording(file.string(), false);
    const auto whole = double(std::filesystem::file_size(file));
    const Carried narrow = carried(*programme, folder / "narrow.mkv", whole / 100 / 4);
    ASSERT_EQ(narrow.indices.size(), 2u);
    EXPECT_GE(narrow.indices.at(0).size(), 3u);
    EXPECT_EQ(narrow.indices.at(0), narrow.indices.at(1));
}

/// By whole rounds too.
TEST(Recordings, SkipWhereTheyAreRepeated) {
    const synthetic::Folder folder;
    synthetic::Made made = synthetic::small_stream(Codec::h264, true);
    made.settings.gop = made.pictures = 30;
    made.settings.pictures = 30;
    synthetic::write(folder / "a.mkv", made);
    const auto programme = open_recording((folder / "a.mkv").string(), true);
    const auto feed = programme->open_feed();
    std::array<char, 1 << 16> block;
    while (feed->next(block, 0).bytes > 0) {
    }
    constexpr double halted_s = 1000;
    std::size_t bytes = 0;
    for (Portion portion; (portion = feed->next(block, halted_s)).bytes > 0;)
        bytes += portion.bytes;
    EXPECT_LE(bytes, 2 * std::filesystem::file_size(folder / "a.mkv"));
}

TEST(Recordings, ThatAreNoMatroskaAreSentWhole) {
    const synthetic::Folder folder;
    synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    made.settings.gop = 4;
    synthetic::write(folder / "a.mp4", made);
    const auto programme = open_recording((folder / "a.mp4").string(), false);
    EXPECT_EQ(carried(*programme, folder / "b.mp4", without_limit, 100).pictures(), std::size_t(made.pictures));
}

TEST(TiledRecordings, SkipToTheNewestGroupForAViewerThatIsFarBehind) {
    const synthetic::Folder folder;
    const synthetic::MadeTiles made{.pictures = 300, .gop = 10, .first_index = 0};
    synthetic::write(folder / "tiles.mkv", made);
    const auto programme = open_recording((folder / "tiles.mkv").string(), false);
    const auto whole = double(std::filesystem::file_size(folder / "tiles.mkv"));
    Carried narrow = carried(*programme, folder / "narrow.mkv", whole / 100);
    EXPECT_LT(narrow.longest_behind_s, 2 + 2);
    ASSERT_EQ(narrow.indices.size(), 1u + std::size_t(made.grid.columns * made.grid.rows));
    narrow.indices = {{0, narrow.indices.at(0)}};
    expect_last_of_groups(narrow, 0, made.pictures, 10);
}

/// An MP4's boxes, by their names and sizes; a size of 0, 1 and others too.
std::string box(const std::string& kind, std::uint32_t said, std::size_t bytes) {
    std::string text;
    for (int shift = 24; shift >= 0; shift -= 8)
        text += char(said >> shift & 0xff);
    return (text + kind).append(bytes - 8, '\0');
}

TEST(RecordedFile, SaysWhetherViewersCanReadItAsItComes) {
    const synthetic::Folder folder;
    const auto file = [&](const std::string& bytes) {
        std::ofstream(folder / "file", std::ios::binary) << bytes;
        return RecordedFile((folder / "file").string());
    };
    const std::string type = box("ftyp", 24, 24), index = box("moov", 32, 32), samples = box("mdat", 64, 64);
    EXPECT_TRUE(file(type + samples + index).index_comes_last());
    EXPECT_FALSE(file(type + index + samples).index_comes_last());
    std::string large = box("free", 1, 40);  // its size is a number of eight bytes behind its name
    large[15] = 40;
    EXPECT_TRUE(file(type + large + samples + index).index_comes_last());
    EXPECT_FALSE(file(type + large + index + samples).index_comes_last());
    large[8] = char(0xff);
    for (const std::string& odd : {std::string(), type, type + box("free", 0, 40) + samples, type + large + samples,
                                   type + box("free", 4, 40) + samples})
        EXPECT_FALSE(file(odd).index_comes_last());
}

/// Whatever pieces it is read in.
TEST(RecordedFile, GivesTheSizeOfItsSegmentAsUnknown) {
    const synthetic::Folder folder;
    const std::string header("\x1a\x45\xdf\xa3\x84\x42\x82\x81\x00", 9), segment("\x18\x53\x80\x67", 4);
    const std::string rest("what follows");
    const auto read = [&](const std::string& bytes, std::size_t piece) -> std::optional<std::string> {
        std::ofstream(folder / "file", std::ios::binary) << bytes;
        RecordedFile file((folder / "file").string());
        if (!file.hide_segment_size())
            return std::nullopt;
        std::string all, part(piece, '\0');
        while (const std::size_t count = file.read(std::int64_t(all.size()), part))
            all.append(part, 0, count);
        return all;
    };
    const std::string known("\x01\x00\x00\x00\x00\x00\x00\x10", 8), unknown("\x01\xff\xff\xff\xff\xff\xff\xff", 8);
    for (const std::size_t piece : {1, 3, 5, 14, 100}) {
        EXPECT_EQ(read(header + segment + known + rest, piece), header + segment + unknown + rest) << piece;
        EXPECT_EQ(read(header + segment + unknown + rest, piece), header + segment + unknown + rest) << piece;
        EXPECT_EQ(read(header + segment + "\x90" + rest, piece), header + segment + "\xff" + rest) << piece;
        EXPECT_EQ(read(header + segment + "\x40\x10" + rest, piece), header + segment + "\x7f\xff" + rest) << piece;
    }
    for (const std::string& odd : {std::string(), header, header + segment, header + segment + std::string(8, '\0')})
        EXPECT_EQ(read(odd, 100), std::nullopt);
}

TEST(RecordedFile, KnowsWhereItsClustersBegin) {
    const synthetic::Folder folder;
    const std::string header("\x1a\x45\xdf\xa3\x84\x42\x82\x81\x00", 9), segment("\x18\x53\x80\x67\xff", 5);
    const std::string cues("\x1c\x53\xbb\x6b\x81x"), cluster("\x1f\x43\xb6\x75\x82yy"), filling("\xec\x80");
    const auto clusters = [&](const std::string& bytes) {
        std::ofstream(folder / "file", std::ios::binary) << bytes;
        return RecordedFile((folder / "file").string()).clusters();
    };
    const std::string start = header + segment;
    using Offsets = std::vector<std::int64_t>;
    EXPECT_EQ(clusters(start + cues + cluster + filling + cluster + cues + cluster), (Offsets{20, 29, 42}));
    const std::string endless("\x1f\x43\xb6\x75\xff"), huge("\x1f\x43\xb6\x75\x01\xff\xff\xff\xff\xff\xff\xfe");
    for (const std::string& odd : {endless + cluster, std::string("\0\0", 2), std::string("\x1f\x43")})
        EXPECT_EQ(clusters(start + cluster + odd), Offsets{14}) << odd.size();
    EXPECT_EQ(clusters(start + cluster + huge + cluster), (Offsets{14, 21})) << "it ends behind the file";
    for (const std::string& none : {std::string(), header, start, start + "text"})
        EXPECT_TRUE(clusters(none).empty());
}

TEST(TiledRecordings, GoOnWithATileForHalfASecondAfterItWasLookedAt) {
    const synthetic::Folder folder;
    synthetic::write(folder / "a.mkv",
                     synthetic::MadeTiles{.grid = {8, 4}, .pictures = 60, .gop = 10, .first_index = 0});
    const auto programme = open_recording((folder / "a.mkv").string(), false);
    const auto feed = programme->open_feed();
    const auto look = [&](double degrees) {
        const glm::dquat turned = glm::angleAxis(degrees * pi / 180, glm::dvec3(0, 1, 0));
        const auto message = encode_viewer_pose({0, {{}, turned}, ViewExtent{0.2, 0.2}});
        feed->hear({reinterpret_cast<const char*>(message.data()), message.size()});
        std::this_thread::sleep_for(std::chrono::milliseconds(300));  // what is older than 0.2 s foretells nothing
    };
    std::ofstream sent(folder / "sent.mkv", std::ios::binary);
    std::array<char, 1 << 16> block;
    look(0);
    bool has_turned = false;
    for (double now_s = 0;; now_s += 1.0 / 60) {
        if (now_s >= 0.5 && !std::exchange(has_turned, true))
            look(180);
        Portion portion;
        while ((portion = feed->next(block, now_s)).bytes > 0)
            sent.write(block.data(), std::streamsize(portion.bytes));
        if (portion.ended || !portion.problem.empty())
            break;
    }
    sent.close();
    StreamReader reader((folder / "sent.mkv").string());
    std::map<std::size_t, int> count;
    while (const auto picture = reader.next())
        ++count[picture->track];
    EXPECT_GE(count[1 + 11], 27) << "15 pictures, and 15 more";
    EXPECT_LE(count[1 + 11], 32);
    EXPECT_GE(count[1 + 8], 45) << "from its key frame on";
}

/// Bytes of the new file would be sent at the old one's times.
TEST(TiledRecordings, RefuseAFileThatHasTakenTheirPlace) {
    const synthetic::Folder folder;
    synthetic::write(folder / "a.mkv", synthetic::MadeTiles{.pictures = 10});
    const auto programme = open_recording((folder / "a.mkv").string(), false);
    EXPECT_NO_THROW(programme->open_feed());
    synthetic::write(folder / "b.mkv", synthetic::MadeTiles{.pictures = 30});
    std::filesystem::rename(folder / "b.mkv", folder / "a.mkv");
    EXPECT_THROW(programme->open_feed(), WorkError);
}

TEST(TiledRecordings, GiveAViewerBehindTheBaseAlone) {
    const synthetic::Folder folder;
    const synthetic::MadeTiles made{.grid = {8, 4}, .pictures = 24, .gop = 24};
    synthetic::write(folder / "tiles.mkv", made);
    const auto programme = open_recording((folder / "tiles.mkv").string(), false);
    const Carried level = carried(*programme, folder / "level.mkv", without_limit);
    const Carried behind = carried(*programme, folder / "behind.mkv", without_limit, 100);
    EXPECT_EQ(level.indices.at(0).size(), 24u);
    EXPECT_EQ(behind.indices.at(0).size(), 24u) << "the base is never left out";
    EXPECT_GT(level.pictures() - 24, 24u);
    EXPECT_EQ(behind.pictures() - 24, 32u) << "the first moment's tiles, by which readers know each track";
}

}  // namespace
}  // namespace equistream::serve
