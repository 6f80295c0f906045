// Every setting that is wrong is refused in one line that names it, what was expected and what was found.
#include "abi_fixture.h"

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
    expect(&S::camera, stored<es_camera_kind>(7), "camera: expected ES_EQUIRECT or ES_PERSPECTIVE, found 7");
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
           "aovs: expected albedo, depth, motion, normal, ids, specular, virtual, all or none, found \"depht\"");
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
    expect(when, "time_s: expected a finite time, found nan");
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
}  // namespace equistream::testing
