#include "synthetic.h"

#include <equistream/error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

namespace equistream {
namespace {

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

struct Case {
    const char* extension;
    Codec codec;
    bool two_tracks;
};

std::string case_name(const testing::TestParamInfo<Case>& info) {
    return std::string(info.param.extension) + (info.param.codec == Codec::h264 ? "_h264" : "_h265") +
           (info.param.two_tracks ? "_two" : "_one");
}

class EveryContainer : public testing::TestWithParam<Case> {
protected:
    synthetic::Folder folder;
    std::filesystem::path file() const { return folder / (std::string("a.") + GetParam().extension); }
};

TEST_P(EveryContainer, FrameInfoSurvivesAndPicturesAreClose) {
    const auto made = synthetic::small_stream(GetParam().codec, GetParam().two_tracks);
    synthetic::write(file(), made);
    StreamReader reader(file().string());
    ASSERT_EQ(reader.tracks().size(), made.settings.tracks.size());
    EXPECT_EQ(reader.tracks()[0].codec, GetParam().codec == Codec::h264 ? "h264" : "hevc");
    EXPECT_EQ(reader.tracks()[0].colour, "tv/bt709/iec61966-2-1/bt709");
    std::map<TrackRole, std::int64_t> next_index;
    double worst_psnr_db = HUGE_VAL;
    for (const DecodedPicture& picture : synthetic::read_all(reader)) {
        const TrackSettings& track = made.settings.tracks[static_cast<std::size_t>(picture.role)];
        ASSERT_EQ(track.role, picture.role);
        const std::int64_t index = made.first_index + next_index[picture.role]++;
        ASSERT_TRUE(picture.info);
        FrameInfo expected = synthetic::info(track.width, track.height, index,
                                             picture.role == TrackRole::main ? Eye::centre : Eye::right);
        expected.crf = float(track.crf.value_or(made.settings.crf));
        expect_same_info(*picture.info, expected);
        const double shown_s = double(index - made.first_index) / 30;
        EXPECT_NEAR(picture.time_s.value_or(shown_s), shown_s, 2e-3);
        worst_psnr_db = std::min(worst_psnr_db,
                                 synthetic::psnr_db(picture.rgb, synthetic::picture(track.width, track.height, index)));
    }
    for (const TrackSettings& track : made.settings.tracks)
        EXPECT_EQ(next_index[track.role], made.pictures);
    EXPECT_GT(worst_psnr_db, 34);  // tiny, fast-moving pictures: Crf16IsCloseToTheSource measures
    EXPECT_EQ(reader.truncation(), "");
}

TEST_P(EveryContainer, TheLengthNeedNotBeKnownBeforehand) {
    auto made = synthetic::small_stream(GetParam().codec, GetParam().two_tracks);
    made.settings.pictures = 0;
    synthetic::write(file(), made);
    StreamReader reader(file().string());
    EXPECT_EQ(synthetic::read_all(reader).size(), made.settings.tracks.size() * made.pictures);
    EXPECT_EQ(reader.truncation(), "");
}

TEST_P(EveryContainer, SameInputGivesSameBytes) {
    const auto made = synthetic::small_stream(GetParam().codec, GetParam().two_tracks);
    synthetic::write(file(), made);
    const std::string first = bytes_of(file());
    synthetic::write(file(), made);
    EXPECT_TRUE(first == bytes_of(file()));
    EXPECT_FALSE(std::filesystem::exists(file().string() + ".part"));
}

INSTANTIATE_TEST_SUITE_P(Stream, EveryContainer,
                         testing::Values(Case{"mp4", Codec::h264, true}, Case{"mp4", Codec::h265, true},
                                         Case{"mkv", Codec::h264, true}, Case{"mkv", Codec::h265, true},
                                         Case{"ts", Codec::h264, true}, Case{"ts", Codec::h265, true},
                                         Case{"nut", Codec::h264, true}, Case{"nut", Codec::h265, true},
                                         Case{"mkv", Codec::h264, false}, Case{"h264", Codec::h264, false},
                                         Case{"h265", Codec::h265, false}),
                         case_name);

TEST(Stream, Crf16IsCloseToTheSource) {
    for (const Codec codec : {Codec::h264, Codec::h265}) {
        synthetic::Folder folder;
        synthetic::Made made;
        made.settings.codec = codec;
        made.settings.tracks = {{TrackRole::main, 480, 240}};
        made.pictures = 6;
        synthetic::write(folder / "a.mkv", made);
        StreamReader reader((folder / "a.mkv").string());
        for (const DecodedPicture& picture : synthetic::read_all(reader))
            EXPECT_GT(synthetic::psnr_db(picture.rgb, synthetic::picture(480, 240, picture.info->index)), 45);
    }
}

TEST(Stream, ColoursComeBackWithinOneStepWhereChromaIsFlat) {
    synthetic::Folder folder;
    StreamSettings settings;
    settings.crf = 0;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 128, 64}};
    const std::uint8_t colours[][3] = {{255, 0, 0}, {0, 255, 0},    {0, 0, 255}, {255, 255, 255},
                                       {0, 0, 0},   {200, 100, 50}, {17, 17, 17}};
    StreamWriter writer((folder / "a.mkv").string(), settings);
    std::int64_t index = 0;
    for (const auto& colour : colours) {
        ByteImage image(128, 64, 3);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 128; ++x)
                std::copy(colour, colour + 3, image.pixel(x, y));
        writer.write(TrackRole::main, image.view(), synthetic::info(128, 64, index++));
    }
    writer.finish();
    StreamReader reader((folder / "a.mkv").string());
    for (const auto& colour : colours) {
        const auto picture = reader.next();
        ASSERT_TRUE(picture);
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 128; ++x)
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(picture->rgb.pixel(x, y)[c], colour[c], 2) << x << ' ' << y << ' ' << c;
    }
}

TEST(Stream, ChromaIsNotShifted) {
    // A linear ramp of colour at constant luma must come back without a sideways step: half a pixel of wrong siting
    // would show as a bias of half the slope.
    synthetic::Folder folder;
    StreamSettings settings;
    settings.crf = 0;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 256, 128}};
    ByteImage ramp(256, 128, 3);
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 256; ++x) {
            ramp.pixel(x, y)[0] = static_cast<std::uint8_t>(x);
            ramp.pixel(x, y)[1] = 128;
            ramp.pixel(x, y)[2] = static_cast<std::uint8_t>(255 - 2 * y);
        }
    StreamWriter writer((folder / "a.mkv").string(), settings);
    writer.write(TrackRole::main, ramp.view(), synthetic::info(256, 128, 0));
    writer.finish();
    StreamReader reader((folder / "a.mkv").string());
    const auto picture = reader.next();
    ASSERT_TRUE(picture);
    double bias[3] = {};
    for (int y = 8; y < 120; ++y)
        for (int x = 16; x < 240; ++x)
            for (int c = 0; c < 3; ++c)
                bias[c] += (double(picture->rgb.pixel(x, y)[c]) - ramp.pixel(x, y)[c]) / (112.0 * 224.0);
    EXPECT_NEAR(bias[0], 0, 0.2);
    EXPECT_NEAR(bias[1], 0, 0.2);
    EXPECT_NEAR(bias[2], 0, 0.3);
}

TEST(Stream, TracksAreNamedAndSpheresTaggedWhereTheContainerCan) {
    for (const char* name : {"a.mp4", "a.mkv"}) {
        synthetic::Folder folder;
        synthetic::write(folder / name, synthetic::small_stream(Codec::h264, true));
        const StreamReader reader((folder / name).string());
        EXPECT_EQ(reader.tracks()[0].name, "main");
        EXPECT_EQ(reader.tracks()[1].name, "small");
        EXPECT_TRUE(reader.tracks()[0].sphere);
        EXPECT_FALSE(reader.tracks()[1].sphere);
    }
}

TEST(Stream, TheTagOfASphereIsPromisedOnlyWhereItArrives) {
    for (const char* name : {"a.mp4", "a.mkv", "a.ts", "a.nut", "a.h264"}) {
        synthetic::Folder folder;
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.tracks = {{TrackRole::main, 192, 96}};
        settings.sphere.emplace();
        StreamWriter writer((folder / name).string(), settings);
        for (const std::int64_t index : {0, 1, 2})
            writer.write(TrackRole::main, synthetic::picture(192, 96, index).view(), synthetic::info(192, 96, index));
        writer.finish();
        const StreamReader reader((folder / name).string());
        EXPECT_EQ(writer.tags_sphere(), reader.tracks()[0].sphere.has_value()) << name;
    }
}

TEST(Stream, TracksInterleave) {
    synthetic::Folder folder;
    auto made = synthetic::small_stream(Codec::h264, true);
    made.pictures = 90;
    made.settings.pictures = 90;
    for (const char* name : {"a.mkv", "a.ts", "a.nut"}) {
        synthetic::write(folder / name, made);
        StreamReader reader((folder / name).string(), {.rgb = false});
        std::map<TrackRole, std::int64_t> last;
        std::int64_t widest = 0;
        while (const auto picture = reader.next()) {
            EXPECT_TRUE(picture->rgb.empty());
            last[picture->role] = picture->info->index;
            if (last.size() == 2)
                widest = std::max(widest, std::abs(last[TrackRole::main] - last[TrackRole::small]));
        }
        EXPECT_LT(widest, 20) << name;  // decoders run a few pictures apart, not a whole file
    }
}

TEST(Stream, BytesAreCountedByTrack) {
    synthetic::Folder folder;
    const auto made = synthetic::small_stream(Codec::h264, true);
    StreamWriter writer((folder / "a.mkv").string(), made.settings);
    for (std::int64_t i = 0; i < made.pictures; ++i)
        for (const TrackSettings& track : made.settings.tracks)
            writer.write(track.role, synthetic::picture(track.width, track.height, i).view(),
                         synthetic::info(track.width, track.height, i));
    writer.finish();
    StreamReader reader((folder / "a.mkv").string());
    synthetic::read_all(reader);
    ASSERT_EQ(writer.bytes().size(), 2u);
    EXPECT_GT(writer.bytes()[0], writer.bytes()[1]);
    // Matroska stores lengths in place of start codes, both of four bytes, or three.
    EXPECT_NEAR(double(reader.tracks()[0].bytes), double(writer.bytes()[0]), 0.01 * double(writer.bytes()[0]) + 40);
    EXPECT_EQ(reader.tracks()[1].pictures, made.pictures);
}

void expect_input_error(const std::string& target, const StreamSettings& settings, const std::string& part) {
    try {
        StreamWriter writer(target, settings);
        ADD_FAILURE() << part;
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

TEST(Stream, BadSettingsAreNamed) {
    synthetic::Folder folder;
    const StreamSettings good = synthetic::small_stream(Codec::h264, true).settings;
    const std::string file = (folder / "a.mkv").string();
    const auto with = [&](auto change) {
        StreamSettings settings = good;
        change(settings);
        return settings;
    };
    expect_input_error((folder / "a.avi").string(), good, "ending in one of .mp4, .mkv, .ts");
    expect_input_error((folder / "a").string(), good, "no extension");
    expect_input_error((folder / "a.h264").string(), good, "one track");
    expect_input_error((folder / "none" / "a.mkv").string(), good, "No such file or directory");
    expect_input_error(file, with([](auto& s) { s.crf = 99; }), "crf: expected 0 to 51, found 99");
    expect_input_error(file, with([](auto& s) { s.gop = 0; }), "gop");
    expect_input_error(file, with([](auto& s) { s.preset = "quick"; }), "one of ultrafast,");
    expect_input_error(file, with([](auto& s) { s.tracks[0].width = 191; }), "even width");
    expect_input_error(file, with([](auto& s) { s.tracks[0].width = 2; }), "2x96");
    expect_input_error(file, with([](auto& s) { s.tracks.clear(); }), "at least one track");
    expect_input_error(file, with([](auto& s) { s.frames_per_second = 0; }), "frames per second");
    EXPECT_FALSE(std::filesystem::exists(file + ".part"));
}

TEST(Stream, WritingTheWrongPicturesIsAnError) {
    synthetic::Folder folder;
    const auto made = synthetic::small_stream(Codec::h264, false);
    StreamWriter writer((folder / "a.mkv").string(), made.settings);
    const auto write = [&](TrackRole role, int width, std::int64_t index) {
        writer.write(role, synthetic::picture(width, 96, index).view(), synthetic::info(width, 96, index));
    };
    write(TrackRole::main, 192, 3);
    EXPECT_THROW(write(TrackRole::main, 192, 3), WorkError);   // not ascending
    EXPECT_THROW(write(TrackRole::main, 190, 4), WorkError);   // another size
    EXPECT_THROW(write(TrackRole::small, 192, 4), WorkError);  // no such track
}

/// Where frame data of this role lies in a file: its UUID, version and size, then the role.
std::vector<std::size_t> payloads_of(const std::string& bytes, TrackRole role) {
    const auto payload = encode_frame_info(role, synthetic::info(64, 64, 0));
    const std::string uuid(payload.begin(), payload.begin() + 16);
    std::vector<std::size_t> places;
    for (std::size_t at = bytes.find(uuid); at != std::string::npos; at = bytes.find(uuid, at + 1))
        if (std::uint8_t(bytes.at(at + 20)) == payload[20])
            places.push_back(at);
    return places;
}

void expect_tiles(const synthetic::MadeTiles& made, StreamReader& reader) {
    std::vector<std::int64_t> next(reader.tracks().size(), made.first_index);
    double worst_psnr_db = HUGE_VAL;
    for (const DecodedPicture& picture : synthetic::read_all(reader)) {
        ASSERT_TRUE(picture.info);
        const std::int64_t index = next[picture.track]++;
        EXPECT_EQ(picture.info->index, index);
        EXPECT_NEAR(picture.info->time_s, double(index) / 30, 1e-9);
        EXPECT_EQ(picture.info->crf, 16.0f);
        if (picture.role == TrackRole::main || picture.role == TrackRole::depth)
            continue;
        const int tile = int(picture.track - 1) / (made.depth ? 2 : 1);
        const FrameInfo expected = synthetic::tile_info(made, tile, index);
        const auto &range = std::get<EquirectCamera>(picture.info->camera).range,
                   &there = std::get<EquirectCamera>(expected.camera).range;
        EXPECT_EQ(range.longitude_min, there.longitude_min);
        EXPECT_EQ(range.latitude_max, there.latitude_max);
        EXPECT_EQ(width_of(picture.info->camera), 64);
        if (picture.role == TrackRole::window_depth) {
            EXPECT_NEAR(*picture.depth_m.pixel(30, 30), synthetic::tile_depth_m(tile), 0.1);
        } else {
            worst_psnr_db =
                std::min(worst_psnr_db, synthetic::psnr_db(picture.rgb, synthetic::tile_picture(made, tile, index)));
        }
    }
    EXPECT_GT(worst_psnr_db, 30);
    for (const std::int64_t index : next)
        EXPECT_EQ(index, made.first_index + made.pictures);
    EXPECT_EQ(reader.truncation(), "");
}

TEST(Stream, TilesCarryFrameDataWithTheirKeyFramesAlone) {
    for (const char* name : {"a.mkv", "a.mp4", "a.ts", "a.nut"})
        for (const Codec codec : {Codec::h264, Codec::h265})
            for (const bool length_is_known : {true, false}) {
                SCOPED_TRACE(std::string(name) + (codec == Codec::h264 ? " H.264" : " H.265"));
                synthetic::Folder folder;
                synthetic::MadeTiles made;
                made.codec = codec;
                made.preset = "veryfast";  // with pictures that are coded before earlier ones
                made.grid = {2, 1};
                made.depth = true;
                made.length_is_known = length_is_known;
                synthetic::write(folder / name, made);
                const std::string bytes = bytes_of(folder / name);
                // Of groups of 4, 4 and 2, if the container has names to know tiles by.
                const std::size_t tagged = length_is_known && std::string_view(name).starts_with("a.m") ? 3 : 10;
                EXPECT_EQ(payloads_of(bytes, TrackRole::main).size(), 10u);
                EXPECT_EQ(payloads_of(bytes, TrackRole::window).size(), 2 * tagged);
                EXPECT_EQ(payloads_of(bytes, TrackRole::window_depth).size(), 2 * tagged);
                StreamReader reader((folder / name).string());
                expect_tiles(made, reader);
            }
}

/// Main and the first so many tiles of {2, 1} in groups of 4.
void write_frames(const std::filesystem::path& file, const std::vector<std::int64_t>& indices, int tiles) {
    const synthetic::MadeTiles made{.grid = {2, 1}};
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.gop = 4;
    settings.pictures = std::uint32_t(indices.size());
    settings.tracks.assign(std::size_t(tiles + 1), {TrackRole::window, 64, 64});
    settings.tracks.front() = {TrackRole::main, 128, 64};
    StreamWriter writer(file.string(), settings);
    for (const std::int64_t index : indices) {
        writer.write(TrackRole::main, synthetic::picture(128, 64, index).view(), synthetic::info(128, 64, index));
        for (int tile = 0; tile < tiles; ++tile)
            writer.write(TrackRole::window, synthetic::tile_picture(made, tile, index).view(),
                         synthetic::tile_info(made, tile, index), std::size_t(tile));
    }
    writer.finish();
}

/// Of each track; -1: it does not say.
std::vector<std::vector<std::int64_t>> indices_of(StreamReader& reader) {
    std::vector<std::vector<std::int64_t>> found(reader.tracks().size());
    for (const DecodedPicture& picture : synthetic::read_all(reader))
        found[picture.track].push_back(picture.info ? picture.info->index : -1);
    return found;
}

TEST(Stream, TilesHaveTheirNumbersWhereFramesAreLeftOut) {
    synthetic::Folder folder;
    const std::vector<std::int64_t> indices = {3, 4, 6, 7, 8, 12, 13};
    write_frames(folder / "a.mkv", indices, 2);
    StreamReader reader((folder / "a.mkv").string());
    EXPECT_EQ(indices_of(reader), std::vector(3, indices));
    EXPECT_EQ(reader.truncation(), "") << "none is missing";
}

/// What a tile's picture does not say its group does; a window alone stands for itself.
TEST(Stream, AWindowThatLostItsDataHasNone) {
    for (const int windows : {1, 2}) {
        synthetic::Folder folder;
        write_frames(folder / "a.mkv", {0, 1, 2, 3, 4, 5, 6, 7}, windows);
        std::string bytes = bytes_of(folder / "a.mkv");
        const auto payloads = payloads_of(bytes, TrackRole::window);
        ASSERT_EQ(payloads.size(), windows == 1 ? 8u : 4u);
        bytes[payloads[windows == 1 ? 4u : 2u]] ^= 0x55;  // of frame 4, which begins the second group
        std::ofstream(folder / "a.mkv", std::ios::binary) << bytes;
        StreamReader reader((folder / "a.mkv").string());
        const std::int64_t fourth = windows == 1 ? -1 : 4;
        EXPECT_EQ(indices_of(reader)[1], (std::vector<std::int64_t>{0, 1, 2, 3, fourth, 5, 6, 7}));
        EXPECT_EQ(reader.truncation().empty(), windows == 2);
    }
}

}  // namespace
}  // namespace equistream
