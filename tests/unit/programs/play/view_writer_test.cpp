/// What play leaves on disk: every view to the last, in each format, and nothing half written.
#include <programs/play/view_writer.h>

#include <client/pipeline/cpu_pipeline.h>

#include <tests/unit/evidence.h>

#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>
#include <equistream/stream.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace equistream::play {
namespace {

namespace fs = std::filesystem;

constexpr int width = 96, height = 64;

/// A ramp across, brighter with each frame; the first column is a gap.
EyePicture view_of_frame(std::int64_t index) {
    EyePicture view;
    view.reset({width, height, 1});
    for (int y = 0; y < height; ++y)
        for (int x = 1; x < width; ++x) {
            const auto grey = std::uint8_t(25 + 127 * x / width + 13 * (index % 8));
            std::fill_n(view.rgba.pixel(x, y), 3, grey);
            view.rgba.pixel(x, y)[3] = 255;
            view.origin.pixel(x, y)[0] = std::uint8_t(PixelOrigin::source);
        }
    return view;
}

FrameInfo info_of_frame(std::int64_t index) {
    FrameInfo info;
    info.index = index;
    info.camera = PerspectiveCamera{width, height, 1.2};
    info.eye = Eye::right;
    info.exposure = 2.5;
    info.scene = "ramp";
    return info;
}

class Views : public testing::Test {
protected:
    void SetUp() override { fs::create_directories(folder_); }
    void TearDown() override { fs::remove_all(folder_); }

    Settings settings(Format format, Layout layout = Layout::files) const {
        Settings settings;
        settings.format = format;
        settings.layout = layout;
        settings.out = folder_;
        return settings;
    }

    /// Writes frames 3 to 7 and returns the bytes that the writer counted.
    std::int64_t write_all(Format format, const FloatImage& depth_m = {}) const {
        ViewWriter views(settings(format), "right");
        for (std::int64_t index = 3; index <= 7; ++index) {
            const EyePicture view = view_of_frame(index);
            views.write({view, depth_m.empty() ? ImageView<const float>{} : depth_m.view(), info_of_frame(index)});
        }
        views.finish();
        return views.bytes();
    }
    static std::int64_t bytes_in(const fs::path& folder) {
        std::int64_t bytes = 0;
        for (const auto& entry : fs::directory_iterator(folder))
            bytes += std::int64_t(entry.file_size());
        return bytes;
    }

    fs::path folder_ = fs::temp_directory_path() / ("equistream_views_" + std::to_string(::getpid()));
};

TEST_F(Views, PicturesAreWhatWasSeen) {
    const std::int64_t bytes = write_all(Format::png);
    EXPECT_EQ(bytes, bytes_in(folder_ / "right"));
    EXPECT_EQ(list_frames(folder_ / "right", "png"), (std::vector<std::int64_t>{3, 4, 5, 6, 7}));
    const ByteImage last = read_picture(folder_ / "right" / "frame.0007.png");
    const ByteImage expected = view_of_frame(7).rgb();
    EXPECT_TRUE(std::ranges::equal(last.samples(), expected.samples())) << test::evidence(last.view(), expected.view());
}

TEST_F(Views, LinearFramesAreTheViewWithoutDisplayTransformAndExposure) {
    const FloatImage depth_m(width, height, 1, 4.5f);
    const std::int64_t bytes = write_all(Format::exr, depth_m);
    EXPECT_EQ(bytes, bytes_in(folder_ / "right"));
    const Frame frame = read_exr(folder_ / "right" / "frame.0007.exr");
    EXPECT_EQ(frame.info.index, 7);
    EXPECT_EQ(frame.info.eye, Eye::right);
    EXPECT_EQ(frame.info.exposure, 2.5);
    EXPECT_EQ(frame.planes.at("depth").pixel(5, 5)[0], 4.5f);
    const FloatImage& colour = frame.planes.at("colour");
    EXPECT_EQ(colour.pixel(0, 3)[3], 0) << "a gap";
    EXPECT_EQ(colour.pixel(1, 3)[3], 1);
    const ByteImage shown = quantise_8bit(DisplayTransform().to_display(colour.view(), 2.5).view());
    const ByteImage expected = view_of_frame(7).rgb();
    int worst = 0;
    for (std::size_t i = 0; i < shown.samples().size(); ++i)
        worst = std::max(worst, std::abs(shown.samples()[i] - expected.samples()[i]));
    EXPECT_LE(worst, 1) << test::evidence(shown.view(), expected.view());
}

TEST_F(Views, AVideoHoldsEveryViewAndHasItsNameOnlyWhenItIsWhole) {
    const fs::path file = folder_ / "right.mp4";
    {
        ViewWriter views(settings(Format::mp4), "right");
        for (std::int64_t index = 3; index <= 7; ++index)
            views.write({view_of_frame(index), {}, info_of_frame(index)});
        EXPECT_FALSE(fs::exists(file));
        views.finish();
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "nothing beside the video";
    StreamReader reader(file.string());
    std::int64_t expected = 3;
    while (const auto picture = reader.next()) {
        ASSERT_TRUE(picture->info);
        EXPECT_EQ(picture->info->index, expected);
        EXPECT_EQ(picture->info->eye, Eye::right);
        EXPECT_NEAR(picture->rgb.pixel(70, 30)[1], view_of_frame(expected).rgba.pixel(70, 30)[1], 5);
        ++expected;
    }
    EXPECT_EQ(expected, 8) << "the last view is frame 7";
    EXPECT_EQ(reader.truncation(), "");
}

TEST_F(Views, AVideoThatIsNamedHoldsBothEyes) {
    Settings named = settings(Format::mp4, Layout::side_by_side);
    named.out = folder_ / "eyes.mp4";
    named.out_is_video = true;
    EyesWriter views(named);
    views.write({view_of_frame(3), {}, info_of_frame(3)}, {view_of_frame(6), {}, info_of_frame(3)});
    views.finish();
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "that file and nothing else";
    StreamReader reader(named.out.string());
    const auto picture = reader.next();
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->rgb.width(), 2 * width);
}

TEST_F(Views, BothEyesShareAPicture) {
    const EyePicture left = view_of_frame(3), right = view_of_frame(6);
    EyesWriter views(settings(Format::png, Layout::side_by_side));
    views.write({left, {}, info_of_frame(3)}, {right, {}, info_of_frame(3)});
    views.finish();
    const fs::path file = folder_ / "both/frame.0003.png";
    EXPECT_EQ(views.bytes(), std::int64_t(fs::file_size(file)));
    const ByteImage both = read_picture(file);
    const ByteImage expected = packed_eyes(StereoPacking::side_by_side, left.rgb().view(), right.rgb().view());
    EXPECT_EQ(both.width(), 2 * width);
    EXPECT_TRUE(std::ranges::equal(both.samples(), expected.samples()));

    Settings coloured = settings(Format::png, Layout::anaglyph);
    coloured.anaglyph = &find_anaglyph("colour");
    EyesWriter(coloured).write({left, {}, info_of_frame(4)}, {right, {}, info_of_frame(4)});
    const ByteImage anaglyph = read_picture(folder_ / "both/frame.0004.png");
    EXPECT_EQ(anaglyph.pixel(70, 30)[0], left.rgba.pixel(70, 30)[0]);
    EXPECT_EQ(anaglyph.pixel(70, 30)[1], right.rgba.pixel(70, 30)[1]);
    EXPECT_EQ(anaglyph.pixel(70, 30)[2], right.rgba.pixel(70, 30)[2]);
}

TEST_F(Views, AVideoOfBothEyesIsOrdinaryStereoVideo) {
    EyesWriter views(settings(Format::mp4, Layout::side_by_side));
    for (std::int64_t index = 3; index <= 7; ++index) {
        const EyePicture left = view_of_frame(index), right = view_of_frame(index + 1);
        views.write({left, {}, info_of_frame(index)}, {right, {}, info_of_frame(index)});
    }
    views.finish();
    StreamReader reader((folder_ / "both.mp4").string());
    EXPECT_EQ(reader.tracks().front().stereo, StereoPacking::side_by_side);
    int pictures = 0;
    while (const auto picture = reader.next()) {
        EXPECT_FALSE(picture->info) << "no one camera took it";
        EXPECT_EQ(picture->width, 2 * width);
        ++pictures;
    }
    EXPECT_EQ(pictures, 5);
    EXPECT_EQ(reader.truncation(), "");
}

TEST_F(Views, AVideoOfNothingIsNoFile) {
    ViewWriter views(settings(Format::mp4), "right");
    views.finish();
    EXPECT_EQ(views.bytes(), 0);
    EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Views, GapMasksAreWhiteWhereNobodyGaveAColour) {
    EyePicture view = view_of_frame(3);
    view.origin.pixel(9, 9)[0] = std::uint8_t(PixelOrigin::neighbours);
    ByteImage mask;
    find_gap_mask(view, mask);
    EXPECT_EQ(mask.pixel(0, 5)[0], 255);
    EXPECT_EQ(mask.pixel(1, 5)[0], 0);
    EXPECT_EQ(mask.pixel(9, 9)[0], 0);
}

TEST_F(Views, AFileInTheWayOfAFolderIsBadInput) {
    std::ofstream(folder_ / "right") << "a file";
    EXPECT_THROW(ViewWriter(settings(Format::png), "right"), InputError);
    EXPECT_THROW(ViewWriter(settings(Format::exr), "right"), InputError);
}

}  // namespace
}  // namespace equistream::play
