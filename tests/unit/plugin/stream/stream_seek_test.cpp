/// Jumps in time: what comes after one is what comes there without, and only a group of pictures is decoded for it.
#include "synthetic.h"

#include <equistream/depth_code.h>
#include <equistream/error.h>

#include <plugin/stream/libav.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace equistream {
namespace {

constexpr int pictures = 40, gop = 6;
constexpr double frames_per_second = 30;

struct Case {
    const char* extension;
    Codec codec;
};

std::string case_name(const testing::TestParamInfo<Case>& info) {
    return std::string(info.param.extension) + (info.param.codec == Codec::h264 ? "_h264" : "_h265");
}

class Jumps : public testing::TestWithParam<Case> {
protected:
    synthetic::Folder folder;

    std::string written(const char* extension, Codec codec) {
        synthetic::Made made = synthetic::small_stream(codec, true);
        made.pictures = pictures;
        made.settings.pictures = pictures;
        made.settings.gop = gop;
        if (std::string(extension) == "h264")
            made.settings.tracks.resize(1);
        first_index = made.first_index;
        const auto file = folder / (std::string("a.") + extension);
        synthetic::write(file, made);
        return file.string();
    }

    std::int64_t first_index = 0;
};

/// As far as the first picture of main, from which times count.
void begin(StreamReader& reader) {
    for (auto picture = reader.next(); picture && picture->role != TrackRole::main;)
        picture = reader.next();
}

using Which = std::pair<TrackRole, std::int64_t>;

Which which(const DecodedPicture& picture) {
    return {picture.role, picture.info->index};
}

TEST_P(Jumps, GiveWhatIsThereAndDecodeNoMoreThanItsGroup) {
    const std::string file = written(GetParam().extension, GetParam().codec);
    StreamReader sequential(file);
    std::map<Which, ByteImage> expected;
    for (DecodedPicture& picture : synthetic::read_all(sequential))
        expected[which(picture)] = std::move(picture.rgb);
    ASSERT_EQ(expected.size(), 2U * pictures);
    const std::int64_t all_bytes = sequential.tracks()[0].bytes;

    StreamReader reader(file);
    EXPECT_FALSE(reader.seek(0)) << "not before the first picture";
    begin(reader);
    for (const int target : {33, 3, 20, 12, 17, 0, 39}) {
        ASSERT_TRUE(reader.seek(target / frames_per_second)) << target;
        const std::int64_t bytes_before = reader.tracks()[0].bytes;
        std::map<TrackRole, std::int64_t> first, next;
        std::int64_t newest = -1;
        while (newest < first_index + target || first.size() < 2) {
            const auto picture = reader.next();
            ASSERT_TRUE(picture) << target;
            EXPECT_EQ(picture->rgb.samples().size(), expected.at(which(*picture)).samples().size());
            EXPECT_TRUE(std::ranges::equal(picture->rgb.samples(), expected.at(which(*picture)).samples()))
                << track_name(picture->role) << ' ' << picture->info->index;
            first.try_emplace(picture->role, picture->info->index);
            next.try_emplace(picture->role, picture->info->index);
            EXPECT_EQ(picture->info->index, next[picture->role]++) << track_name(picture->role) << ", to " << target;
            if (picture->role == TrackRole::main)
                newest = picture->info->index;
        }
        for (const auto& [role, index] : first)
            EXPECT_EQ(index, first_index + target / gop * gop) << track_name(role) << ", to " << target;
        // Decoders hold some pictures back: what they were given by then is more than what came.
        EXPECT_LT(reader.tracks()[0].bytes - bytes_before, all_bytes * 3 / 4) << target;
    }
    EXPECT_TRUE(reader.seek(21 / frames_per_second));
    const auto rest = synthetic::read_all(reader);
    EXPECT_EQ(rest.size(), 2U * (pictures - 18));
    EXPECT_EQ(reader.truncation(), "") << "what was jumped over is not missing";
    EXPECT_TRUE(reader.seek(100));
    EXPECT_EQ(synthetic::read_all(reader).back().info->index, first_index + pictures - 1);
    EXPECT_EQ(reader.truncation(), "");
}

INSTANTIATE_TEST_SUITE_P(Containers, Jumps,
                         testing::Values(Case{"mkv", Codec::h264}, Case{"mkv", Codec::h265}, Case{"mp4", Codec::h264},
                                         Case{"ts", Codec::h264}, Case{"nut", Codec::h264}),
                         case_name);

/// Depth comes out of its encoder sooner than colour, so that its key frame lies before that of the same time.
TEST_P(Jumps, FindKeyFramesThatLieBeforeMains) {
    StreamSettings settings;
    settings.codec = GetParam().codec;
    settings.preset = "ultrafast";
    settings.gop = gop;
    settings.tracks = {{TrackRole::main, 192, 96}, {TrackRole::depth, 192, 96, DepthCodeId::w12}};
    const std::string file = (folder / (std::string("depth.") + GetParam().extension)).string();
    constexpr std::int64_t count = 2 * gop;
    {
        StreamWriter writer(file, settings);
        for (std::int64_t index = 0; index < count; ++index) {
            FrameInfo info = synthetic::info(192, 96, index);
            writer.write(TrackRole::main, synthetic::picture(192, 96, index).view(), info);
            info.depth_code = DepthCodeInfo{DepthCodeId::w12, {0.0315, 1, false}, 0};
            FloatImage depth_m(192, 96, 1);  // which takes some bytes
            for (std::size_t i = 0; i < depth_m.samples().size(); ++i)
                depth_m.samples()[i] = 1 + float((i * 7919 + std::size_t(index)) % 97) / 10;
            writer.write_depth(TrackRole::depth, depth_m.view(), info);
        }
        writer.finish();
    }
    StreamReader reader(file);
    EXPECT_EQ(synthetic::read_all(reader).size(), 2U * count);
    for (const int target : {0, 3, 8, 0, 11}) {
        ASSERT_TRUE(reader.seek(target / frames_per_second)) << target;
        std::map<TrackRole, std::int64_t> seen;
        for (const DecodedPicture& picture : synthetic::read_all(reader))
            ++seen[picture.role];
        for (const TrackRole role : {TrackRole::main, TrackRole::depth})
            EXPECT_EQ(seen[role], count - target / gop * gop) << track_name(role) << ", to " << target;
        EXPECT_EQ(reader.truncation(), "") << "to " << target;
    }
}

/// What the process has read so far, of any file.
std::int64_t bytes_read() {
    std::ifstream counts("/proc/self/io");
    std::string name;
    std::int64_t bytes = 0;
    counts >> name >> bytes;
    return name == "rchar:" ? bytes : throw std::runtime_error("/proc/self/io does not begin with rchar");
}

/// A finished Matroska file says how long it is and where its key frames lie.
TEST(LongJumps, ReadLittleOfTheFile) {
    const synthetic::Folder folder;
    synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    made.pictures = made.settings.pictures = 600;
    made.settings.gop = gop;
    const auto file = folder / "long.mkv";
    synthetic::write(file, made);
    StreamReader reader(file.string());
    begin(reader);
    EXPECT_EQ(reader.seconds(), made.pictures / frames_per_second);
    const std::int64_t before = bytes_read();
    ASSERT_TRUE(reader.seek(590 / frames_per_second));
    const auto picture = reader.next();
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->info->index, made.first_index + 590 / gop * gop);
    EXPECT_LT(bytes_read() - before, std::int64_t(std::filesystem::file_size(file)) / 4);
}

/// Of our own and of somebody else's.
TEST(DamagedStreams, LackNoMoreWhereTheyAreReadAgain) {
    for (const bool tagged : {true, false}) {
        SCOPED_TRACE(tagged ? "ours" : "somebody else's");
        const synthetic::Folder folder;
        synthetic::Made made = synthetic::small_stream(Codec::h264, false);
        made.pictures = pictures;
        made.settings.pictures = pictures;
        made.settings.tagged = tagged;
        const std::string file = folder / "a.mkv";
        synthetic::write(file, made);
        std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
        bytes.seekp(std::streamoff(std::filesystem::file_size(file) / 2));
        bytes << std::string(200, '\0');
        bytes.close();
        StreamReader reader(file);
        // How many pictures the damage costs differs with the decoder's threads.
        for (int round = 0; round < 3; ++round) {
            const std::size_t played = synthetic::read_all(reader).size();
            const std::size_t lacking = std::size_t(pictures) - played;
            EXPECT_NE(reader.truncation().find(tagged ? "lacks " + std::to_string(lacking) + " picture"
                                                      : std::to_string(played) + " play"),
                      std::string::npos)
                << reader.truncation() << "; " << played << " played";
            ASSERT_TRUE(reader.seek(0));
        }
    }
}

/// Of an mp4 libav knows the fragments that it has read, and the header of a file that was cut tells of what is gone.
TEST(Lengths, AreNotKnownOfFragmentsNorOfWhatWasCut) {
    const synthetic::Folder folder;
    const synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    const std::string mp4 = folder / "a.mp4", mkv = folder / "a.mkv";
    synthetic::write(mp4, made);
    synthetic::write(mkv, made);
    EXPECT_FALSE(StreamReader(mp4).seconds());
    EXPECT_NEAR(StreamReader(mkv).seconds().value_or(0), made.pictures / frames_per_second, 0.002);
    std::filesystem::resize_file(mkv, std::filesystem::file_size(mkv) * 6 / 10);
    EXPECT_FALSE(StreamReader(mkv).seconds());
}

/// As ffmpeg does where it is told no more than to make fragments: the movie's header has the first one's pictures.
void copy_into_fragments(const std::string& from, const std::string& to) {
    AVFormatContext* opened = nullptr;
    ASSERT_GE(avformat_open_input(&opened, from.c_str(), nullptr, nullptr), 0);
    const av::Demuxer demuxer(opened);
    opened = nullptr;
    ASSERT_GE(avformat_alloc_output_context2(&opened, nullptr, "mp4", nullptr), 0);
    const av::Muxer muxer(opened);
    for (unsigned i = 0; i < demuxer->nb_streams; ++i) {
        AVStream& stream = *avformat_new_stream(muxer.get(), nullptr);
        ASSERT_GE(avcodec_parameters_copy(stream.codecpar, demuxer->streams[i]->codecpar), 0);
        stream.codecpar->codec_tag = 0;
        stream.time_base = demuxer->streams[i]->time_base;
    }
    av::Options options;
    options.set("movflags", "frag_keyframe");
    ASSERT_GE(avio_open(&muxer->pb, to.c_str(), AVIO_FLAG_WRITE), 0);
    ASSERT_GE(avformat_write_header(muxer.get(), options.taken()), 0);
    const av::Packet packet = av::make_packet();
    while (av_read_frame(demuxer.get(), packet.get()) >= 0) {
        const int i = packet->stream_index;
        av_packet_rescale_ts(packet.get(), demuxer->streams[i]->time_base, muxer->streams[i]->time_base);
        ASSERT_GE(av_interleaved_write_frame(muxer.get(), packet.get()), 0);
    }
    ASSERT_GE(av_write_trailer(muxer.get()), 0);
    avio_closep(&muxer->pb);
}

TEST(Lengths, AreNotKnownWhereFragmentsFollowTheFirstPictures) {
    const synthetic::Folder folder;
    const std::string from = folder / "a.mp4", to = folder / "b.mp4";
    synthetic::write(from, synthetic::small_stream(Codec::h264, false));
    copy_into_fragments(from, to);
    EXPECT_FALSE(StreamReader(to).seconds());
}

using OtherJumps = Jumps;

/// Elementary streams keep no times.
TEST_P(OtherJumps, AreRefusedWhereNothingTellsTheTime) {
    StreamReader reader(written("h264", Codec::h264));
    begin(reader);
    EXPECT_FALSE(reader.seek(0.5));
}

TEST_P(OtherJumps, InACutFileItsCutIsSaidAllTheSame) {
    const std::string file = written("mkv", Codec::h264);
    std::filesystem::resize_file(file, std::filesystem::file_size(file) * 6 / 10);
    StreamReader reader(file);
    begin(reader);
    ASSERT_TRUE(reader.seek(14 / frames_per_second));
    EXPECT_EQ(reader.next()->info->index, first_index + 12);
    std::int64_t last = 0;
    for (const DecodedPicture& picture : synthetic::read_all(reader))
        last = picture.role == TrackRole::main ? picture.info->index : last;
    EXPECT_NE(reader.truncation().find("main was cut after frame " + std::to_string(last)), std::string::npos)
        << reader.truncation();
    EXPECT_NE(reader.truncation().find(std::to_string(last - first_index + 1) + " of " + std::to_string(pictures)),
              std::string::npos)
        << reader.truncation();
}

INSTANTIATE_TEST_SUITE_P(One, OtherJumps, testing::Values(Case{"mkv", Codec::h264}), case_name);

}  // namespace
}  // namespace equistream
