#include "synthetic.h"

#include <equistream/error.h>

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <random>

namespace equistream {
namespace {

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void put_bytes(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

TEST(StreamFaults, WhatAnEarlierRunLeftIsNoPartOfTheFile) {
    const synthetic::Folder folder;
    const auto made = synthetic::small_stream(Codec::h264, false);
    synthetic::write(folder / "alone.mkv", made);
    put_bytes(folder / "a.mkv.part", std::string(1 << 20, 'x'));
    synthetic::write(folder / "a.mkv", made);
    EXPECT_TRUE(bytes_of(folder / "a.mkv") == bytes_of(folder / "alone.mkv"));
}

struct Case {
    const char* name;
    Codec codec;
    bool two_tracks;
};

class CutStream : public testing::TestWithParam<Case> {};

using Pictures = std::map<std::pair<TrackRole, std::int64_t>, ByteImage>;

Pictures by_index(std::vector<DecodedPicture> decoded) {
    Pictures pictures;
    for (DecodedPicture& picture : decoded)
        pictures.emplace(std::pair(picture.role, picture.info->index), std::move(picture.rgb));
    return pictures;
}

/// Every picture that plays must be a picture of the whole stream, bit for bit, and the shortfall must be said.
void expect_plays_up_to_the_cut(const std::filesystem::path& file, const Pictures& whole, std::size_t& played) {
    played = 0;
    try {
        StreamReader reader(file.string());
        while (const auto picture = reader.next()) {
            ASSERT_TRUE(picture->info);
            const auto same = whole.find({picture->role, picture->info->index});
            ASSERT_NE(same, whole.end());
            ASSERT_TRUE(std::equal(same->second.samples().begin(), same->second.samples().end(),
                                   picture->rgb.samples().begin(), picture->rgb.samples().end()))
                << picture->info->index;
            ++played;
        }
        const std::string& line = reader.truncation();
        if (played < whole.size()) {
            EXPECT_NE(line.find("cut"), std::string::npos) << line << " after " << played;
        } else {
            EXPECT_EQ(line, "");
        }
        EXPECT_EQ(line.find('\n'), std::string::npos);
    } catch (const InputError&) {  // cut within the header
    }
}

TEST_P(CutStream, PlaysUpToTheCutAndSaysSo) {
    synthetic::Folder folder;
    const auto file = folder / GetParam().name;
    const auto cut_file = folder / (std::string("cut-") + GetParam().name);
    auto made = synthetic::small_stream(GetParam().codec, GetParam().two_tracks);
    made.pictures = 18;
    made.settings.pictures = 18;
    synthetic::write(file, made);
    StreamReader reader(file.string());
    const Pictures whole = by_index(synthetic::read_all(reader));
    ASSERT_EQ(whole.size(), made.settings.tracks.size() * 18);
    const std::string bytes = bytes_of(file);
    std::size_t previous = 0, played = 0;
    constexpr int cuts = 60;
    for (int i = 0; i <= cuts; ++i) {
        SCOPED_TRACE(i);
        put_bytes(cut_file, bytes.substr(0, bytes.size() * static_cast<std::size_t>(i) / cuts));
        expect_plays_up_to_the_cut(cut_file, whole, played);
        EXPECT_GE(played + 1, previous);  // a later cut plays no less, but for the last packet's benefit of doubt
        if (2 * i >= cuts) {              // half the bytes; a group of 6 may be lost, and encoders' headers count too
            EXPECT_GE(played, whole.size() / 4);
        }
        previous = played;
    }
    EXPECT_EQ(played, whole.size());
}

INSTANTIATE_TEST_SUITE_P(Stream, CutStream,
                         testing::Values(Case{"a.mp4", Codec::h264, true}, Case{"a.mp4", Codec::h265, false},
                                         Case{"a.mkv", Codec::h264, true}, Case{"a.mkv", Codec::h265, true},
                                         Case{"a.ts", Codec::h264, true}, Case{"a.ts", Codec::h265, true},
                                         Case{"a.nut", Codec::h264, true}, Case{"a.nut", Codec::h265, false},
                                         Case{"a.h264", Codec::h264, false}, Case{"a.h265", Codec::h265, false}),
                         [](const auto& test) {
                             std::string name =
                                 test.param.name + std::string(test.param.codec == Codec::h264 ? "h264" : "h265");
                             std::erase(name, '.');
                             return name;
                         });

TEST(StreamFaults, TheCutIsDescribedInOneLine) {
    synthetic::Folder folder;
    synthetic::write(folder / "a.mkv", synthetic::small_stream(Codec::h264, false));
    const std::string bytes = bytes_of(folder / "a.mkv");
    put_bytes(folder / "b.mkv", bytes.substr(0, bytes.size() * 2 / 3));
    StreamReader reader((folder / "b.mkv").string());
    const auto pictures = synthetic::read_all(reader);
    ASSERT_FALSE(pictures.empty());
    EXPECT_EQ(reader.truncation(), (folder / "b.mkv").string() + ": main was cut after frame " +
                                       std::to_string(pictures.back().info->index) + " (" +
                                       std::to_string(pictures.size()) + " of 12 pictures play)");
}

TEST(StreamFaults, DamageInTheMiddleIsSaidAndTheRestPlays) {
    synthetic::Folder folder;
    auto made = synthetic::small_stream(Codec::h264, false);
    made.pictures = 30;
    made.settings.pictures = 30;
    synthetic::write(folder / "a.mkv", made);
    std::string bytes = bytes_of(folder / "a.mkv");
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), 200, '\0');
    put_bytes(folder / "a.mkv", bytes);
    StreamReader reader((folder / "a.mkv").string());
    const auto pictures = synthetic::read_all(reader);
    EXPECT_GE(pictures.size(), 15u);
    EXPECT_LT(pictures.size(), 30u);
    const auto missing = 30 - pictures.size();
    EXPECT_EQ(reader.truncation(), (folder / "a.mkv").string() + ": main lacks " + std::to_string(missing) +
                                       (missing == 1 ? " picture" : " pictures"));
}

/// Where start codes part the units nothing tells whether the last packet is whole, but that it is the last one.
TEST(StreamFaults, DamageLongBeforeTheEndCostsNothingThere) {
    constexpr int count = 60, group = 6;
    for (const char* name : {"a.ts", "a.h264"}) {
        SCOPED_TRACE(name);
        synthetic::Folder folder;
        auto made = synthetic::small_stream(Codec::h264, false);
        made.pictures = count;
        made.settings.pictures = count;
        synthetic::write(folder / name, made);
        std::string bytes = bytes_of(folder / name);
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 4), 200, '\0');
        put_bytes(folder / name, bytes);
        StreamReader reader((folder / name).string());
        std::vector<std::int64_t> indices;  // of pictures whose frame data came
        for (const DecodedPicture& picture : synthetic::read_all(reader))
            if (picture.info)
                indices.push_back(picture.info->index);
        ASSERT_GE(indices.size(), 40u);
        ASSERT_LT(indices.size(), std::size_t(count));
        EXPECT_EQ(indices.back(), made.first_index + count - 1);
        EXPECT_EQ(indices[indices.size() - group], made.first_index + count - group) << "the last group is whole";
        const auto missing = std::size_t(count) - indices.size();
        EXPECT_EQ(reader.truncation(), (folder / name).string() + ": main lacks " + std::to_string(missing) +
                                           (missing == 1 ? " picture" : " pictures"));
    }
}

/// The stream's bytes with another version in the frame data of its pictures, or of its third coded one alone.
std::string with_version(std::string bytes, char version, bool third_only) {
    const std::string uuid = "\x69\xc4\x80\x36\x51\x33\x47\x84\x80\x93\xec\x66\xa7\x47\x51\x19";
    int pictures = 0;
    for (std::size_t at = bytes.find(uuid); at != std::string::npos; at = bytes.find(uuid, at + 1))
        if (++pictures == 3 || !third_only)
            bytes[at + uuid.size()] = version;
    EXPECT_EQ(pictures, 12);
    return bytes;
}

TEST(StreamFaults, AStreamThatBeginsAgainHasEnded) {
    for (const Codec codec : {Codec::h264, Codec::h265}) {
        const synthetic::Folder folder;
        synthetic::write(folder / "once.mkv", synthetic::small_stream(codec, true));
        const std::string once = bytes_of(folder / "once.mkv");
        put_bytes(folder / "twice.mkv", once + once);
        StreamReader reader((folder / "twice.mkv").string());
        std::map<TrackRole, std::vector<std::int64_t>> indices;
        for (const DecodedPicture& picture : synthetic::read_all(reader))
            indices[picture.role].push_back(picture.info->index);
        const std::vector<std::int64_t> expected = {5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
        EXPECT_EQ(indices[TrackRole::main], expected);
        EXPECT_EQ(indices[TrackRole::small], expected);
        EXPECT_EQ(reader.truncation(), "");
    }
}

TEST(StreamFaults, AVersionToComeIsNamedAndIsNoDamage) {
    for (const Codec codec : {Codec::h264, Codec::h265}) {
        synthetic::Folder folder;
        const auto file = folder / "a.mkv";
        synthetic::write(file, synthetic::small_stream(codec, false));
        const std::string bytes = bytes_of(file);
        put_bytes(file, with_version(bytes, 2, false));
        StreamReader later(file.string());
        try {
            later.next();
            ADD_FAILURE() << "version 2 was read";
        } catch (const InputError& error) {
            EXPECT_EQ(error.what(), file.string() + ": frame data in the stream: expected version 1, which this "
                                                    "program reads, found version 2");
        }
        // One picture of another version among many that can be read is damage.
        put_bytes(file, with_version(bytes, 2, true));
        StreamReader damaged(file.string());
        EXPECT_EQ(synthetic::read_all(damaged).size(), 11u);
        EXPECT_NE(damaged.truncation().find("lacks 1 picture"), std::string::npos) << damaged.truncation();
    }
}

TEST(StreamFaults, RandomDamageEndsInPicturesOrOneError) {
    synthetic::Folder folder;
    std::mt19937 generator(3);
    for (const char* name : {"a.mp4", "a.mkv", "a.ts", "a.nut"}) {
        synthetic::write(folder / name, synthetic::small_stream(Codec::h264, true));
        const std::string bytes = bytes_of(folder / name);
        for (int round = 0; round < 25; ++round) {
            std::string damaged = bytes;
            for (int i = 0; i < 12; ++i)
                damaged[generator() % damaged.size()] = static_cast<char>(generator());
            put_bytes(folder / name, damaged);
            try {
                StreamReader reader((folder / name).string());
                for (const DecodedPicture& picture : synthetic::read_all(reader))
                    EXPECT_LE(picture.rgb.width(), max_image_side);
            } catch (const InputError&) {
            }
        }
    }
}

TEST(StreamFaults, WhatIsNoVideoIsSaidSo) {
    synthetic::Folder folder;
    put_bytes(folder / "text.mkv", "not a video at all, whatever its name says\n");
    put_bytes(folder / "empty.mkv", "");
    put_bytes(folder / "list.m3u8", "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nfile:///etc/passwd\n");
    put_bytes(folder / "list.ffconcat", "ffconcat version 1.0\nfile text.mkv\n");
    for (const char* name : {"text.mkv", "empty.mkv", "list.m3u8", "list.ffconcat", "absent.mkv", "."})
        EXPECT_THROW(StreamReader((folder / name).string()), InputError) << name;
}

/// Writes until it fails; the error.
std::string error_of_writing(const std::string& target) {
    auto made = synthetic::small_stream(Codec::h264, false);
    made.settings.crf = 4;
    made.pictures = 200;
    made.settings.pictures = 200;
    try {
        synthetic::write(target, made);
    } catch (const WorkError& error) {
        return error.what();
    }
    return "";
}

TEST(StreamFaults, AFullDeviceIsOneLine) {
    for (const char* name : {"a.mkv", "a.mp4", "a.ts", "a.nut", "a.h264"}) {
        synthetic::Folder folder;
        std::filesystem::create_symlink("/dev/full", folder / name);
        EXPECT_EQ(error_of_writing((folder / name).string()),
                  (folder / name).string() + ": cannot be written: No space left on device");
    }
}

TEST(StreamFaults, AFileThatCannotGrowKeepsWhatWasCoded) {
    // A limit on the size of files stands for a disk that fills up in the middle.
    synthetic::Folder folder;
    const std::string file = (folder / "a.mkv").string();
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{150000, before.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string error = error_of_writing(file);
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_EQ(error, file + ": cannot be written: File too large; what was coded so far is kept in " + file + ".part");
    EXPECT_FALSE(std::filesystem::exists(file));
    StreamReader reader(file + ".part");
    EXPECT_GT(synthetic::read_all(reader).size(), 5u);
    EXPECT_NE(reader.truncation(), "");
}

TEST(StreamFaults, AnAbandonedStreamKeepsEveryPicture) {
    for (const std::uint32_t declared : {0u, 40u}) {
        synthetic::Folder folder;
        const std::string file = (folder / "a.mp4").string();
        auto made = synthetic::small_stream(Codec::h264, false);
        made.settings.pictures = declared;
        {
            StreamWriter writer(file, made.settings);
            EXPECT_EQ(writer.unfinished_file(), file + ".part");
            for (int i = 0; i < 9; ++i)
                writer.write(TrackRole::main, synthetic::picture(192, 96, i).view(), synthetic::info(192, 96, i));
        }
        EXPECT_FALSE(std::filesystem::exists(file));
        StreamReader reader(file + ".part");
        const auto pictures = synthetic::read_all(reader);
        EXPECT_EQ(pictures.size(), 9u);
        EXPECT_NE(reader.truncation().find("cut after frame"), std::string::npos) << reader.truncation();
    }
}

TEST(StreamFaults, FewerPicturesThanDeclaredIsAnError) {
    synthetic::Folder folder;
    const std::string file = (folder / "a.mkv").string();
    const auto made = synthetic::small_stream(Codec::h264, false);
    StreamWriter writer(file, made.settings);
    writer.write(TrackRole::main, synthetic::picture(192, 96, 0).view(), synthetic::info(192, 96, 0));
    EXPECT_THROW(writer.finish(), WorkError);
    EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(StreamFaults, AnEarlierFileStaysUntilTheNewOneIsWhole) {
    synthetic::Folder folder;
    const std::string file = (folder / "a.mkv").string();
    put_bytes(file, "earlier");
    const auto made = synthetic::small_stream(Codec::h264, false);
    {
        StreamWriter writer(file, made.settings);
        writer.write(TrackRole::main, synthetic::picture(192, 96, 0).view(), synthetic::info(192, 96, 0));
    }
    EXPECT_EQ(bytes_of(file), "earlier");
    synthetic::write(file, made);
    EXPECT_GT(bytes_of(file).size(), 1000u);
}

TEST(StreamFaults, ALinkStaysAndTheFileLiesWhereItLeads) {
    const synthetic::Folder folder;
    std::filesystem::create_directories(folder / "large/disk");
    std::filesystem::create_symlink("large/disk/link.mkv", folder / "a.mkv");
    std::filesystem::create_symlink("../b.mkv", folder / "large/disk/link.mkv");
    const auto made = synthetic::small_stream(Codec::h264, false);
    for (const char* state : {"not there yet", "there"}) {
        synthetic::write(folder / "a.mkv", made);
        EXPECT_TRUE(std::filesystem::is_symlink(folder / "a.mkv")) << state;
        EXPECT_TRUE(std::filesystem::is_symlink(folder / "large/disk/link.mkv")) << state;
        EXPECT_TRUE(std::filesystem::is_regular_file(folder / "large/b.mkv")) << state;
    }
}

TEST(StreamFaults, ALinkThatLeadsNowhereIsRefusedBeforeAnythingIsCoded) {
    const synthetic::Folder folder;
    const auto refusal = [&](const std::string& leads_to) -> std::string {
        const std::string file = folder / "a.mkv";
        std::filesystem::remove(file);
        std::filesystem::create_symlink(leads_to, file);
        try {
            const StreamWriter writer(file, synthetic::small_stream(Codec::h264, false).settings);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(refusal("a.mkv"), (folder / "a.mkv").string() + ": expected a place that can be written, found a "
                                                              "symbolic link that leads back to itself");
    EXPECT_EQ(refusal("none/b.mkv"), (folder / "none/b.mkv").string() +
                                         ": expected a place that can be written, found No such file or directory");
}

TEST(StreamFaults, TheUnfinishedFileIsNoSymbolicLink) {
    synthetic::Folder folder;
    const std::string file = (folder / "a.mkv").string();
    put_bytes(folder / "victim", "mine");
    std::filesystem::create_symlink(folder / "victim", file + ".part");
    try {
        StreamWriter writer(file, synthetic::small_stream(Codec::h264, false).settings);
        ADD_FAILURE() << "a symbolic link was followed";
    } catch (const InputError& error) {
        EXPECT_EQ(error.what(),
                  file + ": expected a place that can be written, found " + file + ".part, a symbolic link");
    }
    EXPECT_EQ(bytes_of(folder / "victim"), "mine");
}

TEST(StreamFaults, TwoWritersNeverMixInOneFile) {
    synthetic::Folder folder;
    const std::string file = (folder / "a.mkv").string();
    auto made = synthetic::small_stream(Codec::h264, false);
    made.settings.pictures = made.pictures = 1;
    const auto write_one = [](StreamWriter& writer) {
        writer.write(TrackRole::main, synthetic::picture(192, 96, 0).view(), synthetic::info(192, 96, 0));
        writer.finish();
    };
    StreamWriter first(file, made.settings);
    try {
        StreamWriter second(file, made.settings);
        ADD_FAILURE() << "two writers of one file";
    } catch (const InputError& error) {
        EXPECT_EQ(error.what(), file + ": expected a file that no other process is writing, found " + file +
                                    ".part, which another process is writing");
    }
    write_one(first);
    StreamReader reader(file);
    EXPECT_EQ(synthetic::read_all(reader).size(), 1u);
    // The first one's lock went with its name.
    StreamWriter third(file, made.settings);
    write_one(third);
}

TEST(StreamFaults, WhatReadersTakeForDamageIsNotWritten) {
    synthetic::Folder folder;
    StreamWriter writer((folder / "a.mkv").string(), synthetic::small_stream(Codec::h264, false).settings);
    const ByteImage picture = synthetic::picture(192, 96, 0);
    FrameInfo info = synthetic::info(192, 96, max_frame_index + 1);
    EXPECT_THROW(writer.write(TrackRole::main, picture.view(), info), InputError);
    info = synthetic::info(192, 96, 0);
    info.time_s = 1e11;
    EXPECT_THROW(writer.write(TrackRole::main, picture.view(), info), InputError);
}

TEST(StreamFaults, AnUnwritableFolderIsAnInputError) {
    EXPECT_THROW(StreamWriter("/proc/a.mkv", synthetic::small_stream(Codec::h264, false).settings), InputError);
}

/// libav would send it, and whoever taps would get nothing.
TEST(StreamFaults, AnAddressIsNotTapped) {
    const auto settings = synthetic::small_stream(Codec::h264, false).settings;
    EXPECT_THROW(StreamWriter("udp://127.0.0.1:9/a.ts", settings, StreamTap{.take = [](auto) {}, .alone = false}),
                 InputError);
}

/// Its pictures do not count themselves, but its header says how long it is.
TEST(StreamFaults, ACutMatroskaFileOfSomebodyElseIsNotWhole) {
    synthetic::Folder folder;
    auto made = synthetic::small_stream(Codec::h264, false);
    made.settings.tagged = false;
    const std::string file = folder / "a.mkv", cut_file = folder / "cut.mkv";
    synthetic::write(file, made);
    const std::string bytes = bytes_of(file), kept = bytes.substr(0, bytes.size() * 6 / 10);
    put_bytes(cut_file, kept);
    StreamReader whole(file), cut(cut_file);
    EXPECT_GT(synthetic::read_all(whole).size(), synthetic::read_all(cut).size());
    EXPECT_EQ(whole.truncation(), "");
    EXPECT_EQ(cut.truncation(),
              cut_file + " was cut: its last " + std::to_string(bytes.size() - kept.size()) + " bytes are missing");
}

/// An mp4 goes back to say how long a group's header has become: in memory, where nobody can go back in what is
/// written.
TEST(StreamFaults, LongGroupsAreTheSameThroughATap) {
    synthetic::Folder folder;
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tagged = false;
    settings.gop = 1500;
    settings.pictures = 1500;
    settings.tracks = {{TrackRole::main, 64, 64}, {TrackRole::small, 64, 64}};
    const ByteImage picture(64, 64, 3, 99);
    const std::string file = folder / "a.mp4";
    std::string tapped;
    const StreamTap tap{.take = [&](std::span<const std::uint8_t> bytes) { tapped.append(bytes.begin(), bytes.end()); },
                        .alone = true};
    for (const bool is_tapped : {false, true}) {
        StreamWriter writer(file, settings, is_tapped ? std::optional(tap) : std::nullopt);
        for (std::int64_t index = 0; index < settings.gop; ++index)
            for (const TrackSettings& track : settings.tracks)
                writer.write(track.role, picture.view(), synthetic::info(64, 64, index));
        writer.finish();
    }
    EXPECT_TRUE(bytes_of(file) == tapped);
}

/// What a pipe carries is in Matroska alone not the file's bytes, for nobody can go back in it.
TEST(StreamFaults, APipeCarriesThePicturesOfTheFile) {
    synthetic::Folder folder;
    const auto made = synthetic::small_stream(Codec::h264, true);
    for (const std::string end : {".mkv", ".mp4"}) {
        const std::string file = folder / ("a" + end), pipe = folder / ("pipe" + end), copy = folder / ("copy" + end);
        synthetic::write(file, made);
        ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
        FILE* reader = popen(("cat '" + pipe + "' > '" + copy + "'").c_str(), "w");
        ASSERT_NE(reader, nullptr);
        synthetic::write(pipe, made);
        ASSERT_EQ(pclose(reader), 0);
        StreamReader of_file(file), of_pipe(copy);
        const auto expected = synthetic::read_all(of_file), found = synthetic::read_all(of_pipe);
        EXPECT_EQ(of_pipe.truncation(), "") << end;
        ASSERT_EQ(found.size(), expected.size()) << end;
        for (std::size_t i = 0; i < found.size(); ++i) {
            EXPECT_EQ(found[i].info->index, expected[i].info->index) << end;
            EXPECT_TRUE(std::ranges::equal(found[i].rgb.samples(), expected[i].rgb.samples())) << end << ' ' << i;
        }
        EXPECT_EQ(bytes_of(copy) == bytes_of(file), end == ".mp4");
    }
}

}  // namespace
}  // namespace equistream
