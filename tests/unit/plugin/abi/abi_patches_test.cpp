// Atlases of patches through the C ABI: rays begin at auxiliary spheres, unused slots are holes, nonsense is refused.
#include "abi_fixture.h"

#include <tests/unit/atlas_fixture.h>
#include <tests/unit/plugin/stream/frame_info_matcher.h>

namespace equistream::testing {
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
