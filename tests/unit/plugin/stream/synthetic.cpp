#include "synthetic.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>

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
    made.settings.full_sphere = true;
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

std::vector<DecodedPicture> read_all(StreamReader& reader) {
    std::vector<DecodedPicture> pictures;
    while (auto picture = reader.next())
        pictures.push_back(std::move(*picture));
    return pictures;
}

}  // namespace equistream::synthetic
