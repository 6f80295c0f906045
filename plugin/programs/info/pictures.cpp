#include "pictures.h"

#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <system_error>

namespace equistream {

namespace fs = std::filesystem;

namespace {

int write_frame_pictures(const fs::path& file, const fs::path& folder, const DisplayTransform& display) {
    const Frame frame = read_exr(file);
    int count = 0;
    const auto write = [&](const std::string& plane) {
        const fs::path name = file.stem().string() + "." + plane + ".png";
        write_picture(folder / name, picture_of_plane(frame, plane, display).view());
        ++count;
    };
    for (const auto& [plane, image] : frame.planes)
        write(plane);
    for (const auto& [plane, image] : frame.ids)
        write(plane);
    return count;
}

}  // namespace

int write_pictures(const fs::path& source, const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw InputError(expected_found(folder.string(), "a folder to write to", error.message()));
    const DisplayTransform display;
    if (!fs::is_directory(source))
        return write_frame_pictures(source, folder, display);
    const auto frames = list_frames(source);
    if (frames.empty())
        throw InputError(expected_found(source.string(), "a folder with frame.NNNN.exr files", "none"));
    int count = 0;
    for (const std::int64_t index : frames)
        count += write_frame_pictures(source / frame_file_name(index), folder, display);
    return count;
}

}  // namespace equistream
