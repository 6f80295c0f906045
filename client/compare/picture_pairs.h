#pragma once
/// Which picture is compared with which: folders with one subfolder per eye, folders of frames, or single files.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

struct PairingOptions {
    std::filesystem::path picture;
    std::filesystem::path truth;
    std::optional<std::filesystem::path> second_picture;  ///< both or neither
    std::optional<std::filesystem::path> second_truth;
    std::optional<std::filesystem::path> gaps;  ///< masks, named like the frames; PNG
    std::vector<std::string> eyes;              ///< empty: left and right where they exist, else centre
    std::optional<std::int64_t> first_frame;    ///< both or neither; folders only
    std::optional<std::int64_t> last_frame;
};

struct PicturePair {
    std::optional<std::int64_t> frame;  ///< nothing for a single file
    std::filesystem::path picture;
    std::filesystem::path truth;
    std::filesystem::path second_picture;  ///< empty without a second run
    std::filesystem::path second_truth;
    std::filesystem::path gaps;  ///< empty without masks
};

struct EyePairs {
    std::string eye;  ///< "left", "right", "centre", "small"; "view" for a bare folder of frames or a file
    std::vector<PicturePair> pairs;
};

/// Throws InputError in one line where a side lacks an eye or a frame that another has. Without a frame range all
/// sides must hold the same frames.
std::vector<EyePairs> pair_pictures(const PairingOptions& options);

}  // namespace equistream
