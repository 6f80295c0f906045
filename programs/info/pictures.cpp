#include "pictures.h"

#include "describe.h"

#include <equistream/error.h>
#include <equistream/locks.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

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
    const DisplayTransform display;
    if (!fs::is_directory(source)) {
        if (!is_exr(source))
            throw InputError(expected_found("--pictures", "an EXR frame or a folder of frames",
                                            source.string() + ", another file (play writes the views of a stream)"));
        require_writable_folder(folder);
        return write_frame_pictures(source, folder, display);
    }
    int count = 0;
    for (const fs::path& sequence : sequences_in(source)) {
        // The pictures of a render lie as its frames do.
        const fs::path target = sequence == source ? folder : folder / sequence.filename();
        require_writable_folder(target);
        for (const std::int64_t index : list_frames(sequence))
            count += write_frame_pictures(sequence / frame_file_name(index), target, display);
    }
    return count;
}

}  // namespace equistream
