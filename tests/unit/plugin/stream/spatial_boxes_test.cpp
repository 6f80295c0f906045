/// Apple's boxes in MP4: byte by byte, beside Google's, and of files that are not what they should be.
#include "synthetic.h"

#include <plugin/stream/spatial_boxes.h>

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <random>
#include <sstream>

namespace equistream {
namespace {

constexpr LongitudeLatitudeRange front_half{-pi / 2, pi / 2, -pi / 2, pi / 2};

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string text(const std::vector<std::uint8_t>& bytes) {
    return {bytes.begin(), bytes.end()};
}

/// A box: its size in four bytes, its name, its contents.
std::string box(const std::string& name, const std::string& contents) {
    const auto size = static_cast<std::uint32_t>(8 + contents.size());
    std::string whole;
    for (const int shift : {24, 16, 8, 0})
        whole += static_cast<char>(size >> shift & 255);
    return whole + name + contents;
}

const std::string version(4, '\0');

TEST(VexuBox, IsLaidOutAsAppleHasIt) {
    EXPECT_EQ(text(vexu_box({.sphere = LongitudeLatitudeRange{}})),
              box("vexu", box("proj", box("prji", version + "equi"))));
    EXPECT_EQ(text(vexu_box({.sphere = front_half})), box("vexu", box("proj", box("prji", version + "hequ"))));
    const std::string baseline = {0, 0, '\xf6', '\x18'};  // 63,000 micrometres
    EXPECT_EQ(
        text(vexu_box({.sphere = LongitudeLatitudeRange{}, .stereo = StereoPacking::top_bottom, .baseline_m = 0.063})),
        box("vexu", box("eyes", box("stri", version + "\x03") + box("cams", box("blin", version + baseline))) +
                        box("proj", box("prji", version + "equi")) + box("pack", box("pkin", version + "over"))));
    EXPECT_EQ(text(vexu_box({.stereo = StereoPacking::side_by_side})),
              box("vexu", box("eyes", box("stri", version + "\x03")) + box("pack", box("pkin", version + "side"))));
}

/// What a writer of ours makes of these settings.
std::filesystem::path write(const synthetic::Folder& folder, const std::optional<LongitudeLatitudeRange>& sphere,
                            StereoPacking stereo) {
    synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    made.pictures = 2;
    made.settings.pictures = 2;
    made.settings.tagged = false;
    made.settings.sphere = sphere;
    made.settings.stereo = stereo;
    made.settings.baseline_m = 0.064;
    const std::filesystem::path file = folder / "a.mp4";
    synthetic::write(file, made);
    return file;
}

/// With these names taken out of all boxes: as players that know nothing of them see it.
void hide(const std::filesystem::path& file, std::initializer_list<const char*> names) {
    std::string bytes = bytes_of(file);
    for (const char* name : names)
        for (std::size_t at = bytes.find(name); at != std::string::npos; at = bytes.find(name, at))
            bytes.replace(at, 4, "free");
    std::ofstream(file, std::ios::binary) << bytes;
}

TEST(VexuBox, SaysWhatGooglesBoxesSayAlone) {
    for (const auto& sphere : {std::optional<LongitudeLatitudeRange>(), {LongitudeLatitudeRange{}}, {front_half}})
        for (const StereoPacking stereo : {StereoPacking::none, StereoPacking::side_by_side, StereoPacking::top_bottom})
            for (const auto& hidden : {std::initializer_list<const char*>{}, {"vexu"}, {"st3d", "sv3d"}}) {
                const synthetic::Folder folder;
                const std::filesystem::path file = write(folder, sphere, stereo);
                hide(file, hidden);
                StreamReader reader(file.string());
                const StreamTrackSummary& track = reader.tracks().front();
                ASSERT_EQ(track.sphere.has_value(), sphere.has_value());
                if (sphere) {
                    EXPECT_NEAR(track.sphere->longitude_min, sphere->longitude_min, 1e-8);
                    EXPECT_NEAR(track.sphere->longitude_max, sphere->longitude_max, 1e-8);
                    EXPECT_NEAR(track.sphere->latitude_min, sphere->latitude_min, 1e-8);
                    EXPECT_NEAR(track.sphere->latitude_max, sphere->latitude_max, 1e-8);
                }
                EXPECT_EQ(track.stereo, stereo);
                const bool is_there = (sphere || stereo != StereoPacking::none) && hidden.size() != 1;
                EXPECT_EQ(track.has_vexu, is_there);
                EXPECT_EQ(track.baseline_m.has_value(), is_there && stereo != StereoPacking::none);
                EXPECT_NEAR(track.baseline_m.value_or(0.064), 0.064, 1e-6);
                EXPECT_EQ(synthetic::read_all(reader).size(), 2u);
                EXPECT_EQ(reader.truncation(), "");
            }
}

/// Boxes of 64-bit sizes, one that goes on to the file's end, other boxes in between.
TEST(VexuBox, IsFoundInAnyLayoutOfBoxes) {
    const std::string tags =
        text(vexu_box({.sphere = LongitudeLatitudeRange{}, .stereo = StereoPacking::side_by_side}));
    const auto movie = [&](int header_version) {
        const std::string header = std::string(1, char(header_version)) +
                                   std::string(header_version == 1 ? 19 : 11, '\0') + std::string("\0\0\0\x07", 4) +
                                   std::string(60, '\0');
        const std::string entry =
            box("hvc1", std::string(78, '\x55') + box("hvcC", "xyz") + tags + box("pasp", "12345678"));
        const std::string list = box("stsd", std::string("\0\0\0\0\0\0\0\1", 8) + entry);
        return box("tkhd", header) +
               box("mdia", box("hdlr", "vide") + box("minf", box("vmhd", "") + box("stbl", list)));
    };
    for (const int header_version : {0, 1})
        for (const bool long_size : {false, true}) {
            std::string moov = box("moov", box("mvhd", "abc") + box("trak", movie(header_version)));
            if (long_size) {
                const std::size_t size = moov.size() + 8;
                moov = std::string("\0\0\0\1moov\0\0\0\0", 12) +
                       std::string{char(size >> 24), char(size >> 16), char(size >> 8), char(size)} + moov.substr(8);
            }
            std::istringstream file(box("ftyp", "isom") + moov + std::string("\0\0\0\0mdat", 8) +
                                    std::string(100, 'x'));
            const auto found = read_spatial_tags(file);
            ASSERT_EQ(found.size(), 1u) << header_version << long_size;
            EXPECT_TRUE(found.at(7).sphere);
            EXPECT_EQ(found.at(7).stereo, StereoPacking::side_by_side);
            EXPECT_FALSE(found.at(7).right_first);
        }
}

TEST(VexuBox, ReversedEyesAndOneEyeAloneAreTold) {
    const auto tags_of = [](std::vector<std::uint8_t> vexu, char flags) {
        std::string bytes = text(vexu);
        bytes[bytes.find("stri") + 8] = flags;
        const std::string entry = box("avc1", std::string(78, '\0') + bytes);
        const std::string list = box("stsd", std::string(8, '\0') + entry);
        const std::string track = box("tkhd", std::string(84, '\0')) + box("mdia", box("minf", box("stbl", list)));
        std::istringstream file(box("moov", box("trak", track)));
        return read_spatial_tags(file).at(0);
    };
    const auto vexu = vexu_box({.stereo = StereoPacking::top_bottom});
    EXPECT_TRUE(tags_of(vexu, 11).right_first);
    EXPECT_FALSE(tags_of(vexu, 3).right_first);
    for (const char one : {'\1', '\2', '\0'})
        EXPECT_EQ(tags_of(vexu, one).stereo, StereoPacking::none);
}

/// Nothing is thrown, and no size leads beyond the file.
TEST(VexuBox, DamagedFilesAreReadToTheirEndAtMost) {
    const synthetic::Folder folder;
    const std::string bytes = bytes_of(write(folder, LongitudeLatitudeRange{}, StereoPacking::top_bottom));
    const std::string header = bytes.substr(0, bytes.find("moof"));
    for (std::size_t size = 0; size <= header.size(); ++size) {
        std::istringstream file(header.substr(0, size));
        read_spatial_tags(file);
    }
    std::mt19937 random(1);
    for (int round = 0; round < 20'000; ++round) {
        std::string damaged = header;
        for (int k = 0; k < 3; ++k)
            damaged[random() % damaged.size()] = char(random());
        std::istringstream file(damaged);
        read_spatial_tags(file);
    }
}

TEST(VexuBox, GoesNowhereWhereThereIsNoEntry) {
    EXPECT_TRUE(vexu_box({.sphere = LongitudeLatitudeRange{-1, 1, -1, 1}}).empty()) << "it has no name for that";
    const std::vector<std::uint8_t> more = vexu_box({.sphere = LongitudeLatitudeRange{}});
    for (const std::string& header :
         {std::string(), box("ftyp", "isom"), box("moov", box("trak", "")), std::string(7, 'x')}) {
        const std::vector<std::uint8_t> bytes(header.begin(), header.end());
        EXPECT_EQ(with_box_in_first_entry(bytes, more), bytes);
    }
}

}  // namespace
}  // namespace equistream
