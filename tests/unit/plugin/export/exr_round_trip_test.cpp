// What is written comes back: by our own reader, and by OpenImageIO's (the OpenEXR C++ library) as an independent one.
#include "frame_fixture.h"

#include <equistream/error.h>
#include <equistream/window.h>
#include <tests/unit/atlas_fixture.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <tuple>

namespace equistream::testing {
namespace {

class ExrRoundTrip : public FolderTest {};

template <typename Planes>
void expect_same_planes(const Planes& a, const Planes& b) {
    ASSERT_EQ(a.size(), b.size());
    for (const auto& [name, image] : a) {
        ASSERT_TRUE(b.contains(name)) << name;
        const auto samples = image.samples();
        const auto others = b.find(name)->second.samples();
        EXPECT_TRUE(std::equal(samples.begin(), samples.end(), others.begin(), others.end())) << name;
    }
}

TEST_F(ExrRoundTrip, every_plane_and_attribute_is_exact) {
    // Sizes around the 16-row chunk, odd ones included.
    for (const auto& [width, height] : {std::pair{1, 1}, {3, 15}, {64, 16}, {37, 17}, {130, 65}}) {
        const Frame frame = test_frame(width, height);
        const auto file = folder / "a.exr";
        EXPECT_EQ(write_exr(file, frame), 0);
        const Frame back = read_exr(file);
        expect_same_info(frame.info, back.info);
        expect_same_info(frame.info, read_exr_info(file));
        expect_same_planes(frame.planes, back.planes);
        expect_same_planes(frame.ids, back.ids);
    }
}

TEST_F(ExrRoundTrip, orientations_are_read_at_unit_length) {
    Frame frame = test_frame(8, 4);
    const Pose head = frame.info.head;
    frame.info.camera_pose.orientation = {0.9991, 0, 0, 0};
    frame.info.head.orientation *= 1.0009;
    write_exr(folder / "a.exr", frame);
    const FrameInfo read = read_exr_info(folder / "a.exr");
    EXPECT_EQ(read.camera_pose.orientation, glm::dquat(1, 0, 0, 0));
    EXPECT_LT(glm::length(read.head.orientation - head.orientation), 1e-15);
}

TEST_F(ExrRoundTrip, atlases_of_patches_are_exact) {
    Frame frame = test_frame(48, 32);
    frame.info.camera = EquirectCamera{500, 243, {-2.5, 3.0, -0.7, 1.1}};
    frame.info.patches = random_atlas(3, 2, 1);
    frame.info.patches->range = {-2.5, 3.0, -0.7, 1.1};
    write_exr(folder / "a.exr", frame);
    expect_same_info(frame.info, read_exr(folder / "a.exr").info);
    expect_same_planes(frame.planes, read_exr(folder / "a.exr").planes);
    frame.info.patches->columns = 4;
    frame.info.patches->slots.resize(8);
    EXPECT_THROW(write_exr(folder / "b.exr", frame), InputError);  // its planes are smaller
}

/// OpenEXRCore takes other ways for parts of exactly three or four channels.
TEST_F(ExrRoundTrip, every_plane_alone_is_exact) {
    const Frame all = test_frame(37, 17);
    for (const auto& [name, image] : all.planes) {
        Frame frame;
        frame.info = all.info;
        frame.planes["colour"] = all.planes.at("colour");
        frame.planes[name] = image;
        write_exr(folder / "a.exr", frame);
        expect_same_planes(frame.planes, read_exr(folder / "a.exr").planes);
        const Frame colour = read_exr(folder / "a.exr", {"colour"});
        ASSERT_EQ(colour.planes.size(), 1u);
        const auto expected = all.planes.at("colour").samples();
        EXPECT_TRUE(std::equal(expected.begin(), expected.end(), colour.planes.at("colour").samples().begin())) << name;
    }
}

TEST_F(ExrRoundTrip, single_part_is_exact_too) {
    const Frame frame = test_frame(33, 20);
    const auto file = folder / "a.exr";
    write_exr(file, frame, {.single_part = true});
    const Frame back = read_exr(file);
    expect_same_planes(frame.planes, back.planes);
    expect_same_planes(frame.ids, back.ids);
    const auto in = OIIO::ImageInput::open(file.string());
    ASSERT_TRUE(in);
    EXPECT_FALSE(in->seek_subimage(1, 0));
    const auto& names = in->spec(0).channelnames;
    EXPECT_NE(std::find(names.begin(), names.end(), "Z"), names.end());
}

TEST_F(ExrRoundTrip, perspective_partial_range_and_empty_names) {
    Frame frame = test_frame(8, 4);
    const auto file = folder / "a.exr";
    frame.info.camera = PerspectiveCamera{8, 4, 1.2345678901234567};
    frame.info.scene.clear();
    frame.info.geometry_fingerprint.clear();
    frame.info.eye = Eye::centre;
    write_exr(file, frame);
    expect_same_info(frame.info, read_exr_info(file));
    frame.info.camera = EquirectCamera{8, 4, {-1.0 / 3, 0.1, -0.2, 0.7}};
    write_exr(file, frame);
    expect_same_info(frame.info, read_exr_info(file));
}

TEST_F(ExrRoundTrip, windows_histories_denoisers_and_stereo_spheres_are_said) {
    Frame frame = test_frame(64, 48);
    frame.info.denoiser = "oidn 2";
    frame.info.accumulated_frames = 8;
    frame.info.window_columns = 384;
    frame.info.camera = window_camera({384, 192, 64, 48}, {352, 16});  // over the seam
    write_exr(folder / "a.exr", frame);
    expect_same_info(frame.info, read_exr_info(folder / "a.exr"));
    frame.info = test_info(64, 48);
    ASSERT_TRUE(make_ods(frame.info));
    write_exr(folder / "a.exr", frame);
    expect_same_info(frame.info, read_exr_info(folder / "a.exr"));
}

TEST_F(ExrRoundTrip, chosen_planes_only) {
    const auto file = folder / "a.exr";
    write_exr(file, test_frame(20, 20));
    const Frame back = read_exr(file, {"depth", "material_id"});
    EXPECT_EQ(back.planes.size(), 1u);
    EXPECT_EQ(back.ids.size(), 1u);
    EXPECT_TRUE(std::isinf(back.planes.at("depth").pixel(10, 10)[0]));
}

TEST_F(ExrRoundTrip, a_plane_named_twice_is_read_once) {
    const auto file = folder / "a.exr";
    const Frame frame = test_frame(200, 100);
    write_exr(file, frame);
    const Frame back = read_exr(file, {"depth", "normal", "depth", "material_id", "material_id"});
    EXPECT_EQ(back.planes.size(), 2u);
    for (const char* plane : {"depth", "normal"})
        EXPECT_TRUE(std::ranges::equal(back.planes.at(plane).samples(), frame.planes.at(plane).samples())) << plane;
    EXPECT_TRUE(std::ranges::equal(back.ids.at("material_id").samples(), frame.ids.at("material_id").samples()));
}

TEST_F(ExrRoundTrip, a_missing_plane_is_named_with_those_present) {
    Frame frame = test_frame(4, 4);
    frame.planes.erase("backward");
    const auto file = folder / "a.exr";
    write_exr(file, frame);
    try {
        read_exr(file, {"backward"});
        FAIL() << "expected an InputError";
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()),
                  file.string() + ": expected plane backward, found colour, albedo, depth, forward, normal, "
                                  "object_id, material_id, instance_id, specular, "
                                  "virtual_depth, virtual_backward, virtual_forward, guide_albedo, guide_normal, raw, "
                                  "samples, variance, reference, reference_repeat, crypto_object, crypto_material");
    }
}

TEST_F(ExrRoundTrip, colour_that_a_half_cannot_hold_is_mended_and_counted) {
    Frame frame = test_frame(40, 40);
    FloatImage& colour = frame.planes["colour"];
    colour.pixel(0, 0)[0] = std::nanf("");
    colour.pixel(39, 39)[2] = std::numeric_limits<float>::infinity();
    colour.pixel(5, 20)[1] = 1e9f;
    const auto file = folder / "a.exr";
    EXPECT_EQ(write_exr(file, frame), 2);
    const Frame back = read_exr(file);
    EXPECT_EQ(back.planes.at("colour").pixel(0, 0)[0], 0.0f);
    EXPECT_EQ(back.planes.at("colour").pixel(39, 39)[2], 65504.0f);
    EXPECT_EQ(back.planes.at("colour").pixel(5, 20)[1], 65504.0f);
}

TEST_F(ExrRoundTrip, raw_colour_of_three_channels_is_counted_by_pixels) {
    Frame frame = test_frame(40, 40);
    frame.planes["raw"].pixel(7, 3)[0] = std::nanf("");
    EXPECT_EQ(write_exr(folder / "a.exr", frame), 1);
}

TEST_F(ExrRoundTrip, wrong_shapes_and_unknown_planes_are_refused) {
    Frame frame = test_frame(4, 4);
    frame.planes["depth"] = FloatImage(4, 3, 1);
    EXPECT_THROW(write_exr(folder / "a.exr", frame), InputError);
    frame = test_frame(4, 4);
    frame.planes["heat"] = FloatImage(4, 4, 1);
    EXPECT_THROW(write_exr(folder / "a.exr", frame), InputError);
    EXPECT_TRUE(std::filesystem::is_empty(folder));
}

/// Reads one channel of one part through OpenImageIO.
template <typename T>
std::vector<T> oiio_channel(const std::filesystem::path& file, int part, const std::string& name, OIIO::TypeDesc type) {
    const auto in = OIIO::ImageInput::open(file.string());
    if (!in)
        return {};
    const OIIO::ImageSpec spec = in->spec(part);
    const auto found = std::find(spec.channelnames.begin(), spec.channelnames.end(), name);
    if (found == spec.channelnames.end())
        return {};
    const int c = static_cast<int>(found - spec.channelnames.begin());
    std::vector<T> samples(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
    EXPECT_TRUE(in->read_image(part, 0, c, c + 1, type, samples.data()));
    return samples;
}

TEST_F(ExrRoundTrip, openimageio_reads_the_same_values) {
    const int width = 70;
    const Frame frame = test_frame(width, 35);
    const auto file = folder / "a.exr";
    write_exr(file, frame);
    for (const AovInfo& aov : aov_catalogue())
        for (std::size_t c = 0; c < aov.channels.size(); ++c) {
            const std::string channel(aov.channels[c]);
            const std::string plane(aov.name);
            const int part = aov.data_part ? 1 : 0;
            const std::size_t stride = aov.channels.size();
            if (aov.type == SampleType::id) {
                const auto samples = oiio_channel<std::uint32_t>(file, part, channel, OIIO::TypeDesc::UINT32);
                ASSERT_FALSE(samples.empty()) << channel;
                for (std::size_t i = 0; i < samples.size(); ++i)
                    ASSERT_EQ(samples[i], frame.ids.at(plane).samples()[i * stride + c]) << channel;
                continue;
            }
            const auto samples = oiio_channel<float>(file, part, channel, OIIO::TypeDesc::FLOAT);
            ASSERT_FALSE(samples.empty()) << channel;
            for (std::size_t i = 0; i < samples.size(); ++i)
                ASSERT_EQ(samples[i], frame.planes.at(plane).samples()[i * stride + c]) << channel;
        }
}

TEST_F(ExrRoundTrip, openimageio_reads_the_attributes) {
    const auto file = folder / "a.exr";
    Frame frame = test_frame(64, 32);
    frame.info.frames_per_second = 29.97;  // as people type 30000/1001
    write_exr(file, frame);
    const auto in = OIIO::ImageInput::open(file.string());
    ASSERT_TRUE(in);
    for (int part = 0; part < 2; ++part) {
        const OIIO::ImageSpec spec = in->spec(part);
        EXPECT_EQ(spec.get_string_attribute("oiio:subimagename"), part == 0 ? "rgba" : "data");
        EXPECT_EQ(spec.get_string_attribute("textureformat"), "LatLong Environment");
        EXPECT_EQ(spec.get_string_attribute("wrapmodes"), "periodic,clamp");
        EXPECT_EQ(spec.get_string_attribute("view"), "left");
        EXPECT_EQ(spec.get_string_attribute("compression"), "zip");
        EXPECT_EQ(spec.get_string_attribute("equistream:scene"), "sponza \"quoted\"");
        EXPECT_EQ(spec.get_string_attribute("equistream:seed"), "18364758544493064720");
        const auto* rate = spec.find_attribute("FramesPerSecond");
        ASSERT_NE(rate, nullptr);
        EXPECT_EQ(static_cast<const int*>(rate->data())[0], 30000);
        EXPECT_EQ(static_cast<const int*>(rate->data())[1], 1001);
        EXPECT_NE(spec.find_attribute("chromaticities"), nullptr);
    }
    for (const auto& [rate, over, under] :
         {std::tuple(24.0, 24, 1), {24000.0 / 1001, 24000, 1001}, {12.5, 12500000, 1000000}}) {
        frame.info.frames_per_second = rate;
        write_exr(file, frame);
        const OIIO::ImageSpec spec = OIIO::ImageInput::open(file.string())->spec(0);
        const auto* said = static_cast<const int*>(spec.find_attribute("FramesPerSecond")->data());
        EXPECT_EQ(said[0], over);
        EXPECT_EQ(said[1], under);
        EXPECT_EQ(read_exr_info(file).frames_per_second, rate);
    }
}

/// A compositor crops what is empty: the rest is no whole sphere.
TEST_F(ExrRoundTrip, a_part_of_a_picture_is_refused) {
    struct Crop {
        int left, top, width, height;
    };
    for (const Crop crop : {Crop{4, 0, 16, 8}, {0, 0, 16, 8}, {0, 2, 32, 6}, {0, 0, 32, 6}}) {
        OIIO::ImageSpec spec(crop.width, crop.height, 3, OIIO::TypeDesc::HALF);
        spec.x = crop.left;
        spec.y = crop.top;
        spec.full_width = 32;
        spec.full_height = 8;
        const auto out = OIIO::ImageOutput::create("a.exr");
        const std::vector<float> pixels(std::size_t(crop.width * crop.height * 3), 0.5f);
        ASSERT_TRUE(out->open((folder / "a.exr").string(), spec));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
        ASSERT_TRUE(out->close());
        try {
            read_exr(folder / "a.exr");
            ADD_FAILURE() << crop.left << " " << crop.top;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("equistream import"), std::string::npos) << error.what();
        }
    }
}

TEST_F(ExrRoundTrip, a_foreign_file_has_default_info_and_opaque_alpha) {
    const auto file = folder / "foreign.exr";
    const auto out = OIIO::ImageOutput::create(file.string());
    OIIO::ImageSpec spec(6, 3, 3, OIIO::TypeDesc::FLOAT);
    spec.attribute("compression", "zips");
    spec.x = spec.full_x = 5;
    spec.y = spec.full_y = 7;
    ASSERT_TRUE(out->open(file.string(), spec));
    std::vector<float> pixels(6 * 3 * 3);
    for (std::size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = static_cast<float>(i) * 0.37f;
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
    out->close();
    const Frame frame = read_exr(file);
    EXPECT_EQ(frame.planes.at("colour").pixel(0, 0)[0], pixels.front());
    EXPECT_EQ(frame.planes.at("colour").pixel(5, 2)[2], pixels.back());
    EXPECT_EQ(frame.planes.at("colour").pixel(5, 2)[3], 1.0f);
    EXPECT_EQ(width_of(frame.info.camera), 6);
    EXPECT_THROW(read_exr_info(file), InputError);
}

}  // namespace
}  // namespace equistream::testing
