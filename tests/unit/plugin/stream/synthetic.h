#pragma once
/// Pictures and frame data that tests can predict.
#include <equistream/frame.h>
#include <equistream/stream.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace equistream::synthetic {

/// Smooth coloured waves that move with `index`: a sphere that closes on itself.
ByteImage picture(int width, int height, std::int64_t index);

/// Another pose, time and seed for each index.
FrameInfo info(int width, int height, std::int64_t index, Eye eye = Eye::centre);

double psnr_db(const ByteImage& a, const ByteImage& b);

/// A folder of this test's own, removed with it.
class Folder {
public:
    Folder();
    ~Folder();
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

private:
    std::filesystem::path path_;
};

struct Made {
    StreamSettings settings;
    int pictures = 12;
    std::int64_t first_index = 5;
};

/// 192x96 main and 64x64 small, ultrafast: quick to code.
Made small_stream(Codec codec, bool two_tracks);

/// Writes the stream; main's and small's pictures are picture() of each index.
void write(const std::filesystem::path& file, const Made& made);

/// A sphere of picture() cut into tiles of 64x64, within a base of 128x64.
struct MadeTiles {
    TileGrid grid{4, 2};
    Codec codec = Codec::h264;
    std::string preset = "ultrafast";
    int pictures = 10, gop = 4;
    std::int64_t first_index = 5;
    double frames_per_second = 30;
    bool depth = false;           ///< of tiles tile_depth_m(), and of main the last track: 3 m
    bool length_is_known = true;  ///< beforehand
    int columns() const { return 64 * grid.columns; }
    WindowGrid windows() const { return tile_grid(columns(), grid); }
};
inline constexpr int tiles_base_columns = 128;

/// The part of the sphere of this index that a tile shows, and what its picture says.
ByteImage tile_picture(const MadeTiles& made, int tile, std::int64_t index);
FrameInfo tile_info(const MadeTiles& made, int tile, std::int64_t index);
inline float tile_depth_m(int tile) {
    return 1 + 0.5f * float(tile);
}
void write(const std::filesystem::path& file, const MadeTiles& made);

/// All pictures of a stream in the order they come.
std::vector<DecodedPicture> read_all(StreamReader& reader);

/// To read these bytes as a server sends them, by whatever address: nothing is opened by its name.
StreamReadOptions as_sent(std::string bytes);

}  // namespace equistream::synthetic

namespace equistream {

inline void expect_same_atlas(const PatchAtlas& a, const PatchAtlas& b) {
    EXPECT_EQ(a.sphere_width, b.sphere_width);
    EXPECT_EQ(a.sphere_height, b.sphere_height);
    EXPECT_EQ(a.block_side, b.block_side);
    EXPECT_EQ(a.range.longitude_min, b.range.longitude_min);
    EXPECT_EQ(a.range.longitude_max, b.range.longitude_max);
    EXPECT_EQ(a.range.latitude_min, b.range.latitude_min);
    EXPECT_EQ(a.range.latitude_max, b.range.latitude_max);
    EXPECT_EQ(a.offsets_m, b.offsets_m);
    EXPECT_EQ(a.columns, b.columns);
    EXPECT_EQ(a.rows, b.rows);
    EXPECT_EQ(a.slots, b.slots);
}

/// Every field bit for bit, but for what moves.
inline void expect_same_info(const FrameInfo& a, const FrameInfo& b) {
    EXPECT_EQ(a.index, b.index);
    EXPECT_EQ(a.time_s, b.time_s);
    EXPECT_EQ(a.frames_per_second, b.frames_per_second);
    ASSERT_EQ(a.camera.index(), b.camera.index());
    EXPECT_EQ(width_of(a.camera), width_of(b.camera));
    EXPECT_EQ(height_of(a.camera), height_of(b.camera));
    if (const auto* sphere = std::get_if<EquirectCamera>(&a.camera)) {
        const auto& range = std::get<EquirectCamera>(b.camera).range;
        EXPECT_EQ(sphere->range.longitude_min, range.longitude_min);
        EXPECT_EQ(sphere->range.longitude_max, range.longitude_max);
        EXPECT_EQ(sphere->range.latitude_min, range.latitude_min);
        EXPECT_EQ(sphere->range.latitude_max, range.latitude_max);
        EXPECT_EQ(sphere->ods_side_m, std::get<EquirectCamera>(b.camera).ods_side_m);
    } else {
        EXPECT_EQ(std::get<PerspectiveCamera>(a.camera).fov_x_rad, std::get<PerspectiveCamera>(b.camera).fov_x_rad);
    }
    EXPECT_EQ(a.camera_pose.position_m, b.camera_pose.position_m);
    EXPECT_EQ(a.camera_pose.orientation, b.camera_pose.orientation);
    EXPECT_EQ(a.head.position_m, b.head.position_m);
    EXPECT_EQ(a.head.orientation, b.head.orientation);
    EXPECT_EQ(a.eye, b.eye);
    EXPECT_EQ(a.ipd_m, b.ipd_m);
    EXPECT_EQ(a.lock, b.lock);
    EXPECT_EQ(a.head_radius_m, b.head_radius_m);
    EXPECT_EQ(a.exposure, b.exposure);
    EXPECT_EQ(a.seed, b.seed);
    EXPECT_EQ(a.samples_per_pixel, b.samples_per_pixel);
    EXPECT_EQ(a.scene, b.scene);
    EXPECT_EQ(a.host, b.host);
    EXPECT_EQ(a.geometry_fingerprint, b.geometry_fingerprint);
    ASSERT_EQ(a.patches.has_value(), b.patches.has_value());
    if (a.patches)
        expect_same_atlas(*a.patches, *b.patches);
    EXPECT_EQ(a.depth_code, b.depth_code);
    EXPECT_EQ(a.crf, b.crf);
    EXPECT_EQ(a.visible_loss, b.visible_loss);
    EXPECT_EQ(a.denoiser, b.denoiser);
    EXPECT_EQ(a.accumulated_frames, b.accumulated_frames);
    EXPECT_EQ(a.window_columns, b.window_columns);
    EXPECT_EQ(a.packing, b.packing);
}

}  // namespace equistream
