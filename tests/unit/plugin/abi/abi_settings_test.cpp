// Every setting that is wrong is refused in one line that names it, what was expected and what was found.
#include "abi_fixture.h"

#include <tests/support/patch_ray.h>
#include <tests/unit/atlas_fixture.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace equistream::testing {
namespace {

class AbiSettings : public AbiTest {};

/// What a C host can store in an enum, even if C++ cannot name it.
template <typename Enum>
Enum stored(int number) {
    Enum value{};
    std::memcpy(&value, &number, sizeof value);
    return value;
}

TEST_F(AbiSettings, versions) {
    EXPECT_EQ(es_abi_version(), ES_ABI_VERSION);
    EXPECT_STRNE(es_version(), "");
}

TEST_F(AbiSettings, right_ones_open_and_a_fresh_folder_has_no_frames) {
    es_sequence* sequence = open();
    EXPECT_EQ(es_sequence_has_frame(sequence, 0), 0);
    EXPECT_EQ(es_sequence_has_frame(sequence, -5), 0);
    EXPECT_TRUE(std::filesystem::exists(output + "/manifest.json"));
    es_sequence_close(sequence);
    es_sequence_close(nullptr);
}

TEST_F(AbiSettings, each_wrong_number_is_named) {
    const double nan = std::nan("");
    const auto expect = [&](auto field, auto value, const std::string& line) {
        const es_sequence_settings right = settings;
        settings.*field = value;
        EXPECT_EQ(refusal(), line);
        settings = right;
    };
    using S = es_sequence_settings;
    expect(&S::struct_size, std::size_t{8}, "es_sequence_settings.struct_size: expected at least 176, found 8");
    expect(&S::abi_version, 1u, "abi_version: expected 3, found 1");
    expect(&S::spp, 0u, "spp: expected 1 to 1048576, found 0");
    expect(&S::spp, 1048577u, "spp: expected 1 to 1048576, found 1048577");
    expect(&S::camera, stored<es_camera_kind>(7), "camera: expected ES_EQUIRECT, ES_PERSPECTIVE or ES_ODS, found 7");
    expect(&S::width, 0, "width: expected 1 to 32768, found 0");
    expect(&S::width, 40000, "width: expected 1 to 32768, found 40000");
    expect(&S::height, -1, "height: expected 1 to 32768, found -1");
    expect(&S::eye, stored<es_eye>(-1), "eye: expected ES_EYE_CENTRE, ES_EYE_LEFT or ES_EYE_RIGHT, found -1");
    expect(&S::lock, stored<es_axis_lock>(2), "lock: expected ES_LOCK_WORLD or ES_LOCK_PATH, found 2");
    expect(&S::layer, stored<es_layer>(2), "layer: expected ES_LAYER_FIRST or ES_LAYER_HIDDEN, found 2");
    expect(&S::tile_side, -1, "tile_side: expected 0 to 32768, found -1");
    expect(&S::ipd_m, nan, "ipd_m: expected a number from 0 to 10, found nan");
    expect(&S::head_radius_m, -0.1, "head_radius_m: expected a number from 0 to 1000, found -0.1");
    expect(&S::frames_per_second, 0.0, "frames_per_second: expected a number from 0.001 to 1000, found 0");
    expect(&S::exposure, std::numeric_limits<double>::infinity(),
           "exposure: expected a number from 1e-12 to 1e+12, found inf");
    expect(&S::longitude_min, nan,
           "longitude_min, longitude_max: expected an ascending range in radians, 0.001 to 6.2831853071795862 "
           "wide, found nan to 0");
    expect(&S::output_dir, nullptr, "output_dir: expected a folder, found NULL");
    expect(&S::output_dir, "", "output_dir: expected a folder, found an empty name");
    expect(&S::aovs, nullptr, "aovs: expected groups such as \"depth,motion\", \"all\" or \"none\", found NULL");
    expect(&S::aovs, "depht",
           "aovs: expected albedo, depth, motion, normal, ids, specular, virtual, guides, raw, samples, variance, "
           "reference, cryptomatte, all or "
           "none, found \"depht\"");
    expect(&S::aovs, "raw", "aovs: expected raw only where colour is denoised, found raw");
    expect(&S::aovs, "samples", "aovs: expected samples only where frames are accumulated, found samples");
    expect(&S::accumulate_frames, 1001u, "accumulate_frames: expected at most 1000, found 1001");
    expect(&S::denoise, stored<es_denoise>(4), "denoise: expected ES_DENOISE_OFF to ES_DENOISE_HIGH, found 4");
    expect(&S::denoise_threads, 5000u, "denoise_threads: expected at most 4096, found 5000");
    expect(&S::part_count, 65537u, "part_count: expected at most 65536, found 65537");
    expect(&S::part, 1u, "part: expected at most part_count, 0, found 1");
    const std::string name(256, 'x');
    expect(&S::scene_name, name.c_str(), "scene_name: expected at most 255 bytes, found 256");
    EXPECT_FALSE(std::filesystem::exists(output)) << "a refused sequence leaves nothing behind";
}

TEST_F(AbiSettings, a_host_of_the_first_header_keeps_working) {
    settings.geometry_fingerprint = "g1";
    const auto geometry_with = [&](std::size_t size, std::size_t bytes_there) {
        std::filesystem::remove_all(output);
        settings.struct_size = size;
        // Exactly as long as the host's struct, so that a sanitiser sees any read beyond it.
        const auto storage = std::make_unique<std::byte[]>(bytes_there);
        std::memcpy(storage.get(), &settings, std::min(bytes_there, sizeof settings));
        es_sequence* sequence = nullptr;
        es_error error{};
        const es_status status =
            es_sequence_open(reinterpret_cast<const es_sequence_settings*>(storage.get()), &sequence, &error);
        es_sequence_close(sequence);
        return status == ES_OK ? read_manifest(output).shared.geometry_fingerprint : std::string(error.text);
    };
    constexpr std::size_t first = offsetof(es_sequence_settings, geometry_fingerprint), today = sizeof settings;
    EXPECT_EQ(geometry_with(first - 1, first - 1),
              "es_sequence_settings.struct_size: expected at least 176, found 175");
    EXPECT_EQ(geometry_with(first, first), "") << "fields that the host does not know of are 0";
    EXPECT_EQ(geometry_with(first + 7, first + 7), "") << "half a field is none";
    EXPECT_EQ(geometry_with(first + 8, first + 8), "g1") << "a host of the second header";
    EXPECT_EQ(geometry_with(today, today), "g1");
    EXPECT_EQ(geometry_with(today + 16, today + 16), "g1") << "a host of a later header";
}

TEST_F(AbiSettings, wrong_combinations) {
    settings.part_count = 2;
    settings.accumulate_frames = 4;
    EXPECT_EQ(refusal(), "part_count: expected 0 in an atlas of patches and where frames are accumulated, found 2");
    settings.part_count = settings.accumulate_frames = 0;
    settings.width = settings.height = 32768;
    EXPECT_EQ(refusal(), "width x height: expected at most 268435456 pixels, found 32768x32768");
    settings.width = settings.height = 8;
    settings.camera = ES_PERSPECTIVE;
    settings.fov_x_rad = 0;
    EXPECT_EQ(refusal(), "fov_x_rad: expected radians from 0.001 to pi - 0.001, found 0");
    settings.camera = ES_EQUIRECT;
    settings.latitude_min = 0.2;
    settings.latitude_max = -0.2;
    EXPECT_NE(refusal().find("latitude_min, latitude_max: expected an ascending range"), std::string::npos);
    settings.latitude_max = 2;
    EXPECT_NE(refusal().find("latitude_max: expected latitudes from -pi/2 to pi/2"), std::string::npos);
    settings.latitude_max = 0.2 + 1e-7;
    EXPECT_NE(refusal().find("latitude_max: expected an ascending range"), std::string::npos) << "almost nothing";
}

TEST_F(AbiSettings, null_pointers) {
    es_error error{};
    es_sequence* sequence = nullptr;
    es_frame* frame = nullptr;
    es_tile tile{};
    EXPECT_EQ(es_sequence_open(nullptr, &sequence, &error), ES_BAD_INPUT);
    EXPECT_STREQ(error.text, "es_sequence_settings: expected a pointer, found NULL");
    EXPECT_EQ(es_sequence_open(&settings, nullptr, nullptr), ES_BAD_INPUT);
    EXPECT_EQ(es_frame_begin(nullptr, nullptr, &frame, &error), ES_BAD_INPUT);
    EXPECT_EQ(es_frame_next_tile(nullptr, &tile), ES_BAD_INPUT);
    es_tile_geometry_rays(nullptr, &tile, nullptr);
    es_tile_colour_rays(nullptr, &tile, 0, nullptr);
    es_tile_put_surfaces(nullptr, &tile, nullptr);
    es_tile_put_radiance(nullptr, &tile, nullptr);
    EXPECT_EQ(es_frame_put_plane(nullptr, nullptr, &error), ES_BAD_INPUT);
    EXPECT_EQ(es_frame_end(nullptr, &error), ES_BAD_INPUT);
    EXPECT_EQ(es_sequence_has_frame(nullptr, 0), 0);
    es_frame_discard(nullptr);
}

TEST_F(AbiSettings, a_folder_that_cannot_be_made) {
    put_bytes(folder / "file", "");
    output = (folder / "file" / "below").string();
    settings.output_dir = output.c_str();
    EXPECT_EQ(refusal(), output + ": expected a folder that can be made, found Not a directory");
}

TEST_F(AbiSettings, a_folder_that_cannot_be_written) {
    using std::filesystem::perms;
    std::filesystem::create_directories(output);
    std::filesystem::permissions(output,
                                 perms::owner_read | perms::owner_exec | perms::others_read | perms::others_exec);
    const std::string expected = output + ": expected a writable folder, found Permission denied";
    // Root may write everywhere, so a child process asks as nobody.
    constexpr uid_t nobody = 65534;
    const auto ask = [&] {
        const bool ordinary_user = geteuid() != 0 || setuid(nobody) == 0;
        std::exit(ordinary_user && refusal() == expected ? 0 : 1);
    };
    EXPECT_EXIT(ask(), ::testing::ExitedWithCode(0), "");
}

TEST_F(AbiSettings, frame_settings) {
    es_sequence* sequence = open();
    const auto expect = [&](const es_frame_settings& when, const std::string& line) {
        es_frame* frame = nullptr;
        es_error error{};
        EXPECT_EQ(es_frame_begin(sequence, &when, &frame, &error), ES_BAD_INPUT);
        EXPECT_EQ(frame, nullptr);
        EXPECT_EQ(std::string(error.text), line);
    };
    expect(at(-1), "index: expected 0 to 999999999, found -1");
    es_frame_settings when = at(0);
    when.time_s = std::nan("");
    expect(when, "time_s: expected a number from -1e+10 to 1e+10, found nan");
    when = at(0);
    when.head.position_m[1] = std::nan("");
    expect(when, "head.position_m: expected coordinates from -1e9 to 1e9 metres, found 0 nan 0");
    when = at(0);
    when.head_next.orientation_wxyz[0] = 2;
    expect(when, "head_next.orientation_wxyz: expected a unit quaternion w x y z, found length 2");
    when = at(0);
    when.struct_size = 0;
    expect(when, "es_frame_settings.struct_size: expected at least 192, found 0");
    es_sequence_close(sequence);
}

}  // namespace

// Atlases of patches through the C ABI: rays begin at auxiliary spheres, unused slots are holes, nonsense is refused.

namespace {

class AbiPatches : public AbiTest {
protected:
    void SetUp() override {
        AbiTest::SetUp();
        atlas = random_atlas(5, 4, 21);
        settings.width = atlas.sphere_width;
        settings.height = atlas.sphere_height;
        settings.aovs = "depth";
        settings.tile_side = 48;
        settings.patch_side = atlas.block_side;
        settings.patch_columns = atlas.columns;
        settings.patch_rows = atlas.rows;
        settings.patch_offset_count = static_cast<std::uint32_t>(atlas.offsets_m.size());
        settings.patch_offsets_m = &atlas.offsets_m[0].x;
        for (const PatchAtlas::Slot& s : atlas.slots)
            patches.push_back({s.used, s.offset_index, s.block_x, s.block_y});
    }
    es_frame_settings when(std::int64_t index, const Pose& head = {}) const {
        es_frame_settings frame = at(index, head, head, head);
        frame.patches = patches.data();
        frame.patch_count = patches.size();
        return frame;
    }
    std::string frame_refusal(es_sequence* sequence, const es_frame_settings& settings_of_frame) {
        es_frame* frame = nullptr;
        es_error error{};
        EXPECT_EQ(es_frame_begin(sequence, &settings_of_frame, &frame, &error), ES_BAD_INPUT);
        return error.text;
    }

    PatchAtlas atlas;
    std::vector<es_patch> patches;
};

TEST_F(AbiPatches, rays_are_those_of_the_atlas_and_come_back_in_its_pixels) {
    const Pose head{{3, -2, 5}, glm::normalize(glm::dquat(0.9, 0.1, -0.4, 0.2))};
    settings.lock = ES_LOCK_PATH;  // the atlas turns with the sphere's axes
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, when(3, head));
    es_tile tile{};
    std::vector<es_ray> rays;
    std::size_t seen = 0;
    while (es_frame_next_tile(frame, &tile) == ES_OK) {
        rays.resize(tile.pixel_count);
        std::vector<es_surface> surfaces;
        for (std::uint32_t pass = 0; pass <= tile.sample_count; ++pass) {
            const std::uint32_t count = pass == 0 ? es_tile_geometry_rays(frame, &tile, rays.data())
                                                  : es_tile_colour_rays(frame, &tile, pass - 1, rays.data());
            std::vector<float> rgba;
            for (std::uint32_t i = 0; i < count; ++i) {
                const int x = tile.x + static_cast<int>(rays[i].pixel) % tile.width;
                const int y = tile.y + static_cast<int>(rays[i].pixel) / tile.width;
                ASSERT_TRUE(atlas.slot_at(x, y).used);
                const PatchRay expected = patch_ray(atlas, x, y, x + 0.5, y + 0.5);
                const glm::dvec3 origin = head.position_m + head.orientation * expected.origin_m;
                const glm::dvec3 direction = head.orientation * expected.direction;
                const glm::dvec3 o(rays[i].origin[0], rays[i].origin[1], rays[i].origin[2]);
                const glm::dvec3 d(rays[i].direction[0], rays[i].direction[1], rays[i].direction[2]);
                ASSERT_LT(glm::distance(o, origin), 1e-6);
                ASSERT_LT(glm::distance(d, direction), pass == 0 ? 1e-6 : 2 * pi / 500);
                es_surface surface = miss(rays[i]);
                surface.distance_m = static_cast<float>(1 + x + 1000 * y);
                surfaces.push_back(surface);
                rgba.insert(rgba.end(), {static_cast<float>(x), static_cast<float>(y), 7, 1});
                seen += pass == 0;
            }
            if (pass == 0)
                es_tile_put_surfaces(frame, &tile, surfaces.data());
            else
                es_tile_put_radiance(frame, &tile, rgba.data());
        }
    }
    EXPECT_EQ(seen, atlas.used_slots() * 256);
    end(frame);
    es_sequence_close(sequence);

    const Frame written = read_exr(std::filesystem::path(output) / frame_file_name(3));
    ASSERT_TRUE(written.info.patches);
    expect_same_atlas(*written.info.patches, atlas);
    EXPECT_EQ(width_of(written.info.camera), atlas.sphere_width);
    EXPECT_EQ(written.info.camera_pose.position_m, head.position_m);
    const FloatImage& depth = written.planes.at("depth");
    const FloatImage& colour = written.planes.at("colour");
    ASSERT_EQ(depth.width(), atlas.width());
    ASSERT_EQ(depth.height(), atlas.height());
    for (int y = 0; y < atlas.height(); ++y)
        for (int x = 0; x < atlas.width(); ++x) {
            const float* rgba = colour.pixel(x, y);
            if (!atlas.slot_at(x, y).used) {
                EXPECT_TRUE(std::isnan(depth.pixel(x, y)[0]));
                EXPECT_EQ(rgba[3], 0);
                continue;
            }
            EXPECT_EQ(depth.pixel(x, y)[0], static_cast<float>(1 + x + 1000 * y));
            EXPECT_EQ(rgba[0], x);
            EXPECT_EQ(rgba[1], y);
            EXPECT_EQ(rgba[3], 1);
        }
}

TEST_F(AbiPatches, a_sequence_is_resumed_with_the_same_patches_only) {
    es_sequence_close(open());
    EXPECT_EQ(read_manifest(output).shared.patches->offsets_m, atlas.offsets_m);
    es_sequence_close(open());
    settings.patch_columns = 4;
    settings.patch_rows = 5;
    EXPECT_NE(refusal().find("expected patches {"), std::string::npos) << refusal();
    settings.patch_side = 0;
    EXPECT_NE(refusal().find(output), std::string::npos);
}

TEST_F(AbiPatches, nonsense_is_refused_in_one_line) {
    const es_sequence_settings right = settings;
    const auto refused = [&](auto change) {
        settings = right;
        change(settings);
        return refusal();
    };
    EXPECT_NE(refused([](auto& s) { s.patch_side = 2; }).find("patches of 4 to 64 pixels"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.patch_columns = 1 << 20; }).find("patch_columns"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.patch_rows = -1; }).find("patch_columns"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.patch_offset_count = 65; }).find("patch_offset_count"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.patch_offsets_m = nullptr; }).find("patch_offset_count"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.camera = ES_PERSPECTIVE; }).find("patch_side"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.layer = ES_LAYER_HIDDEN; }).find("patch_side"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.layer = stored<es_layer>(3); }).find("patch_side"), std::string::npos);
    EXPECT_NE(refused([](auto& s) { s.aovs = "motion"; }).find("no motion"), std::string::npos);
    settings = right;
    es_sequence* sequence = open();
    es_frame_settings frame = when(0);
    frame.patch_count -= 1;
    EXPECT_NE(frame_refusal(sequence, frame).find("5 x 4 slots"), std::string::npos) << frame_refusal(sequence, frame);
    patches[3] = {1, 7, 0, 0};
    EXPECT_NE(frame_refusal(sequence, when(0)).find("offset below 7"), std::string::npos);
    patches[3] = {1, 1u << 31, 0, 0};
    EXPECT_NE(frame_refusal(sequence, when(0)).find("patches[3]"), std::string::npos);
    frame.patches = nullptr;
    EXPECT_NE(frame_refusal(sequence, frame).find("patches"), std::string::npos);
    es_sequence_close(sequence);
    settings.patch_side = 0;
    output += "2";
    settings.output_dir = output.c_str();
    patches[3] = {};
    sequence = open();
    EXPECT_NE(frame_refusal(sequence, when(0)).find("no atlas"), std::string::npos);
    es_sequence_close(sequence);
}

}  // namespace
}  // namespace equistream::testing
