#pragma once
/// Which files make a sequence: folders and patterns in, frames out. A frame is one file, or one for each AOV.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace equistream::files {

struct FileSets {
    std::vector<std::string> stems;  ///< what tells the sets apart: "beauty", "depth"; one for each file of a frame
    struct Frame {
        std::int64_t index = 0;
        std::vector<std::filesystem::path> files;  ///< as many as stems
    };
    struct Missing {
        std::int64_t index = 0;
        std::string text;  ///< "frame 7", "frame 12 of depth"
    };
    std::vector<Frame> frames;  ///< ascending
    std::vector<Missing> missing;
};

/// Sources are folders, files, or patterns whose run of # stands for the frame's number. Throws InputError.
FileSets find_files(const std::vector<std::string>& sources);

}  // namespace equistream::files
