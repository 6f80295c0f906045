#pragma once
/// Pictures and frame data that tests can predict.
#include <equistream/stream.h>

#include <filesystem>

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

/// All pictures of a stream in the order they come.
std::vector<DecodedPicture> read_all(StreamReader& reader);

}  // namespace equistream::synthetic
