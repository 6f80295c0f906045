#include "synthetic.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

/// libx265 3.5 does not free the user data of an encoder's last picture.
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions() {
    return "leak:libx265\n";
}

namespace equistream::synthetic {

ByteImage picture(int width, int height, std::int64_t index) {
    ByteImage image(width, height, 3);
    const double time = 0.15 * static_cast<double>(index);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double l = 2 * pi * (x + 0.5) / width;
            const double p = pi * (y + 0.5) / height;
            const double waves[] = {std::sin(l + time), std::sin(2 * l - time + p), std::cos(3 * p + time)};
            for (int c = 0; c < 3; ++c)
                image.pixel(x, y)[c] = static_cast<std::uint8_t>(std::lround(127.5 + 100 * waves[c] * std::sin(p)));
        }
    return image;
}

FrameInfo info(int width, int height, std::int64_t index, Eye eye) {
    FrameInfo result;
    const auto i = static_cast<double>(index);
    result.index = index;
    result.time_s = i / 30;
    result.camera = EquirectCamera{width, height, {}};
    result.camera_pose.position_m = {0.1 * i, 1.6, -0.03 * i};
    result.head = {result.camera_pose.position_m, glm::normalize(glm::dquat(1, 0, 0.05 * i, 0))};
    result.eye = eye;
    result.exposure = 1.5;
    result.head_radius_m = 0.1;
    result.seed = 1000 + static_cast<std::uint64_t>(index);
    result.samples_per_pixel = 64;
    result.scene = "waves";
    result.host = "synthetic 1";
    result.geometry_fingerprint = "0123456789abcdef";
    return result;
}

double psnr_db(const ByteImage& a, const ByteImage& b) {
    EXPECT_EQ(a.samples().size(), b.samples().size());
    double sum = 0;
    for (std::size_t i = 0; i < a.samples().size(); ++i) {
        const double difference = double(a.samples()[i]) - double(b.samples()[i]);
        sum += difference * difference;
    }
    return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.samples().size()) / sum);
}

Folder::Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "equistream-test-XXXXXX").string();
    if (!mkdtemp(name.data()))
        throw std::runtime_error("no temporary folder");
    path_ = name;
}

Folder::~Folder() {
    std::filesystem::remove_all(path_);
}

Made small_stream(Codec codec, bool two_tracks) {
    Made made;
    made.settings.codec = codec;
    made.settings.preset = "veryfast";
    made.settings.gop = 6;
    made.settings.tracks = {{TrackRole::main, 192, 96}};
    if (two_tracks)
        made.settings.tracks.push_back({TrackRole::small, 96, 64});
    made.settings.scene = "waves";
    made.settings.sphere.emplace();
    made.settings.pictures = static_cast<std::uint32_t>(made.pictures);
    return made;
}

void write(const std::filesystem::path& file, const Made& made) {
    StreamWriter writer(file.string(), made.settings);
    for (std::int64_t index = made.first_index; index < made.first_index + made.pictures; ++index)
        for (const TrackSettings& track : made.settings.tracks)
            writer.write(
                track.role, picture(track.width, track.height, index).view(),
                info(track.width, track.height, index, track.role == TrackRole::main ? Eye::centre : Eye::right));
    writer.finish();
}

namespace {

ByteImage part_of(const ByteImage& sphere, const WindowGrid& grid, WindowPlace place) {
    ByteImage part(grid.width, grid.height, 3);
    for (int y = 0; y < grid.height; ++y)
        std::copy_n(sphere.pixel(place.x, place.y + y), 3 * grid.width, part.pixel(0, y));
    return part;
}

}  // namespace

ByteImage tile_picture(const MadeTiles& made, int tile, std::int64_t index) {
    const WindowGrid grid = made.windows();
    return part_of(picture(grid.columns, grid.rows, index), grid, tile_place(grid, made.grid, tile));
}

FrameInfo tile_info(const MadeTiles& made, int tile, std::int64_t index) {
    const WindowGrid grid = made.windows();
    FrameInfo result = info(grid.width, grid.height, index);
    result.camera = window_camera(grid, tile_place(grid, made.grid, tile));
    result.frames_per_second = made.frames_per_second;
    result.time_s = double(index) / made.frames_per_second;
    return result;
}

void write(const std::filesystem::path& file, const MadeTiles& made) {
    constexpr int width = tiles_base_columns, height = width / 2;
    const WindowGrid grid = made.windows();
    StreamSettings settings;
    settings.codec = made.codec;
    settings.preset = made.preset;
    settings.gop = made.gop;
    settings.frames_per_second = made.frames_per_second;
    settings.pictures = made.length_is_known ? std::uint32_t(made.pictures) : 0;
    settings.tracks = {{TrackRole::main, width, height}};
    for (int tile = 0; tile < made.grid.count(); ++tile) {
        settings.tracks.push_back({TrackRole::window, grid.width, grid.height});
        if (made.depth)
            settings.tracks.push_back({TrackRole::window_depth, grid.width, grid.height, DepthCodeId::w10});
    }
    if (made.depth)
        settings.tracks.push_back({TrackRole::depth, width, height, DepthCodeId::w10});
    const DepthCodeInfo depth_code{DepthCodeId::w10, {0.0315, 1, true}, 0};
    StreamWriter writer(file.string(), settings);
    for (std::int64_t index = made.first_index; index < made.first_index + made.pictures; ++index) {
        FrameInfo of_main = tile_info(made, 0, index);
        of_main.camera = EquirectCamera{width, height, {}};
        writer.write(TrackRole::main, picture(width, height, index).view(), of_main);
        const ByteImage sphere = picture(grid.columns, grid.rows, index);
        for (int tile = 0; tile < made.grid.count(); ++tile) {
            FrameInfo tagged = tile_info(made, tile, index);
            const ByteImage part = part_of(sphere, grid, tile_place(grid, made.grid, tile));
            writer.write(TrackRole::window, part.view(), tagged, std::size_t(tile));
            tagged.depth_code = depth_code;
            if (made.depth)
                writer.write_depth(TrackRole::window_depth,
                                   FloatImage(grid.width, grid.height, 1, tile_depth_m(tile)).view(), tagged,
                                   std::size_t(tile));
        }
        of_main.depth_code = depth_code;
        if (made.depth)
            writer.write_depth(TrackRole::depth, FloatImage(width, height, 1, 3).view(), of_main);
    }
    writer.finish();
}

std::vector<DecodedPicture> read_all(StreamReader& reader) {
    std::vector<DecodedPicture> pictures;
    while (auto picture = reader.next())
        pictures.push_back(std::move(*picture));
    return pictures;
}

StreamReadOptions as_sent(std::string bytes) {
    StreamReadOptions options;
    options.read = [left = std::move(bytes)](std::span<std::uint8_t> room) mutable {
        const std::size_t count = std::min(left.size(), room.size());
        std::copy_n(left.begin(), count, room.begin());
        left.erase(0, count);
        return count;
    };
    return options;
}

}  // namespace equistream::synthetic
