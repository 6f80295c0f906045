/// Depth tracks beside colour: every code through its codec, in every container, whole and damaged.
#include "frame_info_matcher.h"
#include "synthetic.h"

#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/error.h>
#include <equistream/half_depth.h>
#include <equistream_client/receive.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>

namespace equistream {
namespace {

constexpr int width = 192, height = 128, pictures = 8;
constexpr DepthRange range{0.0315, 0.75, false};

/// A floor and a sky, and before them a ball that moves with `index`.
FloatImage depth_of(std::int64_t index) {
    FloatImage depth_m(width, height, 1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double down = (y + 0.5 - height / 2.0) / height * pi;
            const bool ball = std::hypot(x - 60.0 - 2.0 * double(index), y - 48.0) < 20;
            depth_m.pixel(x, y)[0] = ball ? 0.75f : down > 0.02 ? float(1.6 / std::sin(down)) : HUGE_VALF;
        }
    return depth_m;
}

FrameInfo info_of(std::int64_t index, std::optional<DepthCodeId> code = {}) {
    FrameInfo info = synthetic::info(width, height, index);
    if (code)
        info.depth_code = DepthCodeInfo{*code, range, 0};
    return info;
}

StreamSettings settings_of(Codec codec, DepthCodeId code) {
    StreamSettings settings;
    settings.codec = codec;
    settings.preset = "veryfast";
    settings.gop = 4;
    settings.tracks = {{TrackRole::main, width, height}, {TrackRole::depth, width, height, code}};
    return settings;
}

void write(const std::string& file, const StreamSettings& settings, DepthCodeId code) {
    StreamWriter writer(file, settings);
    for (std::int64_t index = 0; index < pictures; ++index) {
        writer.write(TrackRole::main, synthetic::picture(width, height, index).view(), info_of(index));
        writer.write_depth(TrackRole::depth, depth_of(index).view(), info_of(index, code));
    }
    writer.finish();
}

std::string bytes_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// By how much pixels are displaced, those of surfaces and those of the sky.
struct Displacements {
    std::vector<double> surfaces_rad, sky_rad;

    void add(const FloatImage& depth_m, const FloatImage& used_m) {
        for (std::size_t i = 0; i < depth_m.samples().size(); ++i) {
            const float here_m = depth_m.samples()[i];
            (std::isinf(here_m) ? sky_rad : surfaces_rad)
                .push_back(displacement_bound_rad(here_m, used_m.samples()[i], range.box_radius_m));
        }
    }
};

/// So much of it is no larger.
double quantile(std::vector<double> values, double part) {
    const auto at = values.begin() + std::ptrdiff_t(part * double(values.size() - 1));
    std::ranges::nth_element(values, at);
    return *at;
}

/// What a codec leaves half of the pixels within. Both standards step a block's transform, which keeps lengths, by
/// 2^((QP - 4) / 6) of an 8-bit sample; so its errors have that over sqrt(12) as their standard deviation, and pixels,
/// sums of many, are spread normally. However a code lays out its bits, eight of them go through the codec as w8's do,
/// whose 255 is the w of near_m; a rate factor is the mean QP.
double median_codec_error_rad() {
    const double quantiser_step = std::exp2((StreamSettings{}.crf - 4) / 6), normal_median = 0.6745;
    const double w = bounded_inverse_depth(range.near_m, range.box_radius_m) / 255;
    return normal_median * quantiser_step / std::sqrt(12.0) * w;
}

struct Case {
    DepthCodeId code;
    Codec codec;
    const char* extension;
};

class DepthTracks : public testing::TestWithParam<Case> {
protected:
    synthetic::Folder folder;
    std::string file() const { return folder / (std::string("a.") + GetParam().extension); }
};

TEST_P(DepthTracks, ComeBackBesideTheirColour) {
    const StreamSettings settings = settings_of(GetParam().codec, GetParam().code);
    write(file(), settings, GetParam().code);
    StreamReader reader(file());
    std::map<TrackRole, std::int64_t> next;
    Displacements off;
    while (const auto picture = reader.next()) {
        const std::int64_t index = next[picture->role]++;
        ASSERT_TRUE(picture->info);
        const bool depth = picture->role == TrackRole::depth;
        EXPECT_EQ(picture->depth_m.empty(), !depth);
        EXPECT_EQ(picture->rgb.empty(), depth);
        FrameInfo expected = info_of(index, depth ? std::optional(GetParam().code) : std::nullopt);
        if (const auto crf = settings.tracks[depth ? 1 : 0].coded_crf(settings.crf))
            expected.crf = float(*crf);
        EXPECT_EQ(expected.crf.has_value(), !depth || GetParam().code != DepthCodeId::lossless);
        expect_same_info(*picture->info, expected);
        if (!depth)
            continue;
        EXPECT_TRUE(GetParam().code != DepthCodeId::lossless ||
                    std::ranges::equal(picture->depth_m.samples(), depth_of(index).samples()))
            << index;
        off.add(depth_of(index), picture->depth_m);
    }
    EXPECT_EQ(reader.truncation(), "");
    EXPECT_EQ(next[TrackRole::main], pictures);
    ASSERT_EQ(next[TrackRole::depth], pictures);
    // Nearly all of it is within the whole budget; lossless loses nothing.
    const double quantisation_rad = quantisation_bound_rad(*make_depth_code(GetParam().code), range);
    const bool lossless = GetParam().code == DepthCodeId::lossless;
    EXPECT_LE(quantile(off.surfaces_rad, 0.5), lossless ? 0 : quantisation_rad + median_codec_error_rad());
    EXPECT_LE(quantile(off.surfaces_rad, 0.95), lossless ? 0 : error_budget_rad(default_focal_length_px));
    EXPECT_LE(quantile(off.sky_rad, 0.95), lossless ? 0 : error_budget_rad(default_focal_length_px));
    const auto& track = *std::ranges::find(reader.tracks(), TrackRole::depth, &StreamTrackSummary::role);
    EXPECT_EQ(track.codec, settings.tracks[1].codec(GetParam().codec) == Codec::h264 ? "h264" : "hevc");
}

/// As a hidden layer has it: a band beside the ball shows what lies behind, everything else nothing.
FloatImage band_of(std::int64_t index) {
    FloatImage depth_m(width, height, 1, std::nanf(""));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double r = std::hypot(x - 60.0 - 2.0 * double(index), y - 48.0);
            if (r >= 12 && r < 20)
                depth_m.pixel(x, y)[0] = y < 48 ? HUGE_VALF : float(1.5 + 0.02 * y);
        }
    return depth_m;
}

TEST_P(DepthTracks, PixelsWithoutASurfaceStaySo) {
    const DepthCodeInfo code{GetParam().code, {range.box_radius_m, range.near_m, true}, 0};
    StreamSettings settings = settings_of(GetParam().codec, GetParam().code);
    settings.tracks.push_back({TrackRole::hidden, width, height});
    settings.tracks.push_back({TrackRole::hidden_depth, width, height, GetParam().code});
    {
        StreamWriter writer(file(), settings);
        for (std::int64_t index = 0; index < pictures; ++index) {
            const ByteImage colour = synthetic::picture(width, height, index);
            FrameInfo hidden = info_of(index);
            hidden.depth_code = code;
            writer.write(TrackRole::main, colour.view(), info_of(index));
            writer.write_depth(TrackRole::depth, depth_of(index).view(), info_of(index, GetParam().code));
            writer.write(TrackRole::hidden, colour.view(), info_of(index));
            writer.write_depth(TrackRole::hidden_depth, band_of(index).view(), hidden);
        }
        writer.finish();
    }
    const auto feed = open_feed(file(), {.depth = true});
    std::int64_t index = 0, surfaces = 0, lost = 0, invented = 0;
    for (; const auto frame = feed->next(); ++index) {
        ASSERT_TRUE(frame->hidden);
        const FloatImage sent = band_of(index);
        ASSERT_EQ(frame->hidden->depth_m.samples().size(), sent.samples().size());
        for (std::size_t i = 0; i < sent.samples().size(); ++i) {
            const bool was = !std::isnan(sent.samples()[i]), is = !std::isnan(frame->hidden->depth_m.samples()[i]);
            surfaces += was;
            lost += was && !is;
            invented += is && !was;
        }
    }
    EXPECT_EQ(index, pictures);
    EXPECT_GT(surfaces, 1000);
    EXPECT_EQ(lost, 0);
    EXPECT_EQ(invented, 0);
}

TEST_P(DepthTracks, SameInputGivesSameBytes) {
    write(file(), settings_of(GetParam().codec, GetParam().code), GetParam().code);
    const std::string first = bytes_of(file());
    write(file(), settings_of(GetParam().codec, GetParam().code), GetParam().code);
    EXPECT_TRUE(first == bytes_of(file()));
}

INSTANTIATE_TEST_SUITE_P(
    Stream, DepthTracks,
    testing::Values(Case{DepthCodeId::w8, Codec::h264, "mp4"}, Case{DepthCodeId::w8, Codec::h265, "nut"},
                    Case{DepthCodeId::w10, Codec::h264, "mkv"}, Case{DepthCodeId::w10, Codec::h265, "ts"},
                    Case{DepthCodeId::w12, Codec::h264, "mp4"}, Case{DepthCodeId::w12, Codec::h265, "mkv"},
                    Case{DepthCodeId::pece444, Codec::h264, "nut"}, Case{DepthCodeId::pece420, Codec::h264, "mp4"},
                    Case{DepthCodeId::hue, Codec::h264, "mkv"}, Case{DepthCodeId::lossless, Codec::h264, "mp4"},
                    Case{DepthCodeId::lossless, Codec::h265, "ts"}),
    [](const auto& tested) {
        return std::string(depth_code_name(tested.param.code)) +
               (tested.param.codec == Codec::h264 ? "_h264_" : "_h265_") + tested.param.extension;
    });

TEST(DepthStreams, AFeedGivesDepthWithItsColourOrLeavesItOut) {
    const synthetic::Folder folder;
    for (const char* name : {"a.mkv", "a.ts"}) {  // with names of tracks and without
        const std::string file = folder / name;
        write(file, settings_of(Codec::h264, DepthCodeId::w10), DepthCodeId::w10);
        for (const bool depth : {true, false}) {
            const auto feed = open_feed(file, {.depth = depth});
            int frames = 0;
            while (const auto frame = feed->next()) {
                EXPECT_EQ(frame->main.depth_m.empty(), !depth);
                EXPECT_EQ(frame->main.info.depth_code.has_value(), depth);
                EXPECT_FALSE(frame->small);
                ++frames;
            }
            EXPECT_EQ(frames, pictures);
            EXPECT_EQ(feed->truncation(), "");
            std::int64_t depth_pictures = -1;
            for (const FeedTrack& track : feed->tracks())
                if (track.name == "depth")
                    depth_pictures = track.pictures;
            EXPECT_EQ(depth_pictures, depth ? pictures : 0) << name;
        }
    }
}

TEST(DepthStreams, AFeedGivesTheDecodersOwnPlanes) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    write(file, settings_of(Codec::h264, DepthCodeId::w10), DepthCodeId::w10);
    const auto as_rgb = open_feed(file), as_yuv = open_feed(file, {.yuv = true});
    std::vector<ReceivedFrame> kept;  // planes outlive the decoder's next pictures
    while (auto frame = as_yuv->next())
        kept.push_back(std::move(*frame));
    ASSERT_EQ(kept.size(), std::size_t(pictures));
    for (const ReceivedFrame& frame : kept) {
        const auto rgb = as_rgb->next();
        ASSERT_TRUE(rgb && rgb->main.yuv.empty() && frame.main.rgb.empty() && !frame.main.yuv.empty());
        EXPECT_EQ(frame.main.width(), width);
        EXPECT_EQ(frame.main.height(), height);
        const YuvView& planes = frame.main.yuv.planes;
        EXPECT_EQ(planes.cb.width, width / 2);
        // Luma of the RGB that was made of it, within what rounding and clipping leave.
        double sum = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint8_t* c = rgb->main.rgb.pixel(x, y);
                const double luma = 16 + bt709::luma_scale * (bt709::kr * c[0] + bt709::kg * c[1] + bt709::kb * c[2]);
                sum += std::abs(luma - planes.y.row(y)[x]);
            }
        EXPECT_LT(sum / (width * height), 1.0);
    }
}

TEST(DepthStreams, ALostDepthPictureLeavesItsColour) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.nut";
    StreamSettings settings = settings_of(Codec::h264, DepthCodeId::w8);
    StreamWriter writer(file, settings);
    for (std::int64_t index = 0; index < pictures; ++index) {
        writer.write(TrackRole::main, synthetic::picture(width, height, index).view(), info_of(index));
        if (index != 3)
            writer.write_depth(TrackRole::depth, depth_of(index).view(), info_of(index, DepthCodeId::w8));
    }
    writer.finish();
    const auto feed = open_feed(file, {.depth = true});
    std::int64_t frames = 0;
    for (; const auto frame = feed->next(); ++frames)
        EXPECT_EQ(frame->main.depth_m.empty(), frames == 3);
    EXPECT_EQ(frames, pictures);
}

/// Changes the frame data of every picture of a file that starts with `role`.
void edit_frame_data(const std::string& file, TrackRole role, const std::function<void(char*, std::size_t)>& edit) {
    std::string bytes = bytes_of(file);
    const auto payload = encode_frame_info(role, {});
    const std::string start(payload.begin(), payload.begin() + 18);
    int edited = 0;
    for (std::size_t at = bytes.find(start); at != bytes.npos; at = bytes.find(start, at + 1))
        if (bytes[at + 20] == char(role)) {
            edit(bytes.data() + at, bytes.size() - at);
            ++edited;
        }
    ASSERT_GT(edited, 0);
    std::ofstream(file, std::ios::binary) << bytes;
}

TEST(DepthStreams, PicturesWhoseDataLieAreLeftOut) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.nut";
    // A depth track that says it is colour; colour that says it is depth; another code's samples.
    for (const auto& [role, claimed_role, claimed_code] :
         {std::tuple{TrackRole::depth, TrackRole::hidden, -1},
          {TrackRole::main, TrackRole::depth, -1},
          {TrackRole::depth, TrackRole::depth, int(DepthCodeId::pece444)},
          {TrackRole::depth, TrackRole::depth, int(DepthCodeId::w12)}}) {
        write(file, settings_of(Codec::h264, DepthCodeId::w10), DepthCodeId::w10);
        std::string radius(sizeof(double), ' ');  // two bytes behind the code
        std::memcpy(radius.data(), &range.box_radius_m, sizeof(double));
        edit_frame_data(file, role, [&, c_role = claimed_role, code = claimed_code](char* payload, std::size_t left) {
            payload[20] = char(c_role);
            const std::size_t at = std::string_view(payload, std::min<std::size_t>(left, 600)).find(radius);
            if (code >= 0 && at != std::string_view::npos)
                payload[at - 2] = char(code);
        });
        StreamReader reader(file);
        while (const auto picture = reader.next())
            EXPECT_NE(picture->role, claimed_role == TrackRole::hidden ? TrackRole::hidden : TrackRole::patches);
        EXPECT_NE(reader.truncation(), "");
        EXPECT_EQ(reader.truncation().find('\n'), std::string::npos);
    }
}

TEST(DepthStreams, EveryCutPlaysUpToItOrIsToldInOneLine) {
    const synthetic::Folder folder;
    const std::string whole = folder / "a.mkv", cut = folder / "cut.mkv";
    write(whole, settings_of(Codec::h264, DepthCodeId::w10), DepthCodeId::w10);
    const std::string bytes = bytes_of(whole);
    for (int part = 1; part < 16; ++part) {
        std::ofstream(cut, std::ios::binary) << bytes.substr(0, bytes.size() * std::size_t(part) / 16);
        try {
            const auto feed = open_feed(cut, {.depth = true});
            while (const auto frame = feed->next())
                EXPECT_GE(frame->main.info.index, 0);
            EXPECT_NE(feed->truncation(), "") << part;
            EXPECT_EQ(feed->truncation().find('\n'), std::string::npos);
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
    }
}

StreamSettings halved_settings(DepthCodeId code, double crf) {
    StreamSettings settings = settings_of(Codec::h264, code);
    settings.tracks[1].halved = true;
    settings.tracks[1].crf = crf;
    return settings;
}

TEST(DepthStreams, HalvedDepthComesBackAtItsPicturesSize) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    write(file, halved_settings(DepthCodeId::lossless, 16), DepthCodeId::lossless);
    StreamReader reader(file);
    std::int64_t index = 0;
    while (const auto picture = reader.next())
        if (picture->role == TrackRole::depth) {
            EXPECT_TRUE(picture->info->depth_code->halved);
            ASSERT_EQ(picture->width, width);
            ASSERT_EQ(picture->height, height);
            const FloatImage expected = double_depth(halve_depth(depth_of(index).view()).view());
            EXPECT_TRUE(std::ranges::equal(picture->depth_m.samples(), expected.samples())) << index;
            ++index;
        }
    EXPECT_EQ(index, pictures);
    const auto& track = *std::ranges::find(reader.tracks(), TrackRole::depth, &StreamTrackSummary::role);
    EXPECT_EQ(track.width, width / 2);
    EXPECT_EQ(track.height, height / 2);
}

/// Colour that goes with depth_of(), so that it tells the ball from what is behind.
ByteImage colour_of(std::int64_t index) {
    ByteImage rgb(width, height, 3, 60);
    const FloatImage depth_m = depth_of(index);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (*depth_m.pixel(x, y) == 0.75f)
                std::fill_n(rgb.pixel(x, y), 3, std::uint8_t{200});
    return rgb;
}

TEST(DepthStreams, AFeedTellsHalvedDepthApartByItsColour) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    {
        StreamSettings settings = halved_settings(DepthCodeId::lossless, 16);
        settings.crf = 8;
        StreamWriter writer(file, settings);
        for (std::int64_t index = 0; index < pictures; ++index) {
            writer.write(TrackRole::main, colour_of(index).view(), info_of(index));
            writer.write_depth(TrackRole::depth, depth_of(index).view(), info_of(index, DepthCodeId::lossless));
        }
        writer.finish();
    }
    for (const bool yuv : {false, true}) {
        const auto feed = open_feed(file, {.depth = true, .yuv = yuv});
        std::int64_t wrong = 0, wrong_without = 0, index = 0;
        for (; const auto frame = feed->next(); ++index) {
            const FloatImage sent = depth_of(index), repeated = double_depth(halve_depth(sent.view()).view());
            ASSERT_EQ(frame->main.depth_m.samples().size(), sent.samples().size());
            const auto is_ball = [](float r) { return r == 0.75f; };
            for (std::size_t i = 0; i < sent.samples().size(); ++i) {
                wrong += is_ball(frame->main.depth_m.samples()[i]) != is_ball(sent.samples()[i]);
                wrong_without += is_ball(repeated.samples()[i]) != is_ball(sent.samples()[i]);
            }
        }
        EXPECT_EQ(index, pictures);
        EXPECT_GT(wrong_without, 40 * pictures);
        EXPECT_LT(wrong * 5, wrong_without);
    }
}

TEST(DepthStreams, WritersRefuseWhatCannotBeCoded) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    StreamSettings settings = settings_of(Codec::h264, DepthCodeId::w10);
    settings.tracks[1].depth_code.reset();
    EXPECT_THROW(StreamWriter(file, settings), InputError);
    settings = settings_of(Codec::h264, DepthCodeId::w10);
    settings.tracks[0].depth_code = DepthCodeId::w10;
    EXPECT_THROW(StreamWriter(file, settings), InputError);
    settings = settings_of(Codec::h264, DepthCodeId::w10);
    settings.tracks[1].crf = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(StreamWriter(file, settings), InputError);
    settings = halved_settings(DepthCodeId::w10, 16);
    settings.tracks[0].halved = true;  // colour
    EXPECT_THROW(StreamWriter(file, settings), InputError);
    for (const auto& [w, h] : {std::pair{width + 2, height}, {width, 2 * min_track_side - 4}}) {
        settings = halved_settings(DepthCodeId::w10, 16);
        settings.tracks[1].width = w;
        settings.tracks[1].height = h;
        EXPECT_THROW(StreamWriter(file, settings), InputError) << w << "x" << h;
    }

    StreamWriter writer(file, settings_of(Codec::h264, DepthCodeId::w10));
    const FloatImage depth_m = depth_of(0);
    EXPECT_THROW(writer.write_depth(TrackRole::depth, depth_m.view(), info_of(0)), WorkError);
    EXPECT_THROW(writer.write_depth(TrackRole::depth, depth_m.view(), info_of(1, DepthCodeId::w8)), WorkError);
    EXPECT_THROW(writer.write_depth(TrackRole::main, depth_m.view(), info_of(2, DepthCodeId::w10)), WorkError);
    EXPECT_THROW(writer.write(TrackRole::depth, synthetic::picture(width, height, 3).view(), info_of(3)), WorkError);
}

}  // namespace
}  // namespace equistream
