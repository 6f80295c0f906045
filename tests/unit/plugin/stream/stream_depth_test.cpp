/// Depth tracks beside colour: every code through its codec, in every container.
#include "depth_stream.h"
#include "synthetic.h"

#include <client/receive/receive.h>
#include <equistream/bound.h>
#include <equistream/depth_code.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace equistream::test {
namespace {

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
    const bool lossless = GetParam().code == DepthCodeId::lossless;
    const double nearest_w = bounded_inverse_depth(range.near_m, range.box_radius_m);
    const double rounding_rad = lossless ? 0 : nearest_w / (2 * make_depth_code(GetParam().code)->levels(range));
    EXPECT_LE(quantile(off.surfaces_rad, 0.5), lossless ? 0 : rounding_rad + median_codec_error_rad());
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

}  // namespace
}  // namespace equistream::test
