#include "picture_pairs.h"

#include <equistream/error.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace equistream {

namespace {

namespace fs = std::filesystem;

/// One eye's pictures on one side of the comparison.
struct Side {
    fs::path place;         ///< a file, or a folder of frames
    std::string extension;  ///< empty for a file
    std::vector<std::int64_t> frames;

    bool is_file() const { return extension.empty(); }
    bool holds(std::int64_t frame) const { return std::binary_search(frames.begin(), frames.end(), frame); }
    fs::path file(std::int64_t frame) const { return place / frame_file_name(frame, extension); }
};

bool is_folder(const fs::path& path) {
    std::error_code ignored;
    return fs::is_directory(path, ignored);
}

Side open_side(const fs::path& place) {
    std::error_code ignored;
    if (fs::is_regular_file(place, ignored))
        return {place, "", {}};
    if (!is_folder(place))
        throw InputError(expected_found(place.string(), "a picture or a folder of frames", "nothing"));
    Side png{place, "png", list_frames(place, "png")};
    Side exr{place, "exr", list_frames(place, "exr")};
    if (!png.frames.empty() && !exr.frames.empty())
        throw InputError(
            expected_found(place.string(), "frames of one format", "both frame.NNNN.png and frame.NNNN.exr"));
    if (png.frames.empty() && exr.frames.empty())
        throw InputError(expected_found(place.string(), "frame.NNNN.png or frame.NNNN.exr", "no frame"));
    return png.frames.empty() ? exr : png;
}

std::vector<fs::path> roots_of(const PairingOptions& options) {
    std::vector<fs::path> roots{options.picture, options.truth};
    for (const auto& root : {options.second_picture, options.second_truth, options.gaps})
        if (root)
            roots.push_back(*root);
    return roots;
}

/// Subfolders to compare; {""} where the roots themselves are folders of frames or files.
std::vector<std::string> choose_eyes(const PairingOptions& options) {
    static constexpr std::array accepted{"left", "right", "centre", "small"};
    for (const std::string& eye : options.eyes)
        if (std::find(accepted.begin(), accepted.end(), eye) == accepted.end())
            throw InputError(expected_found("--eyes", "left, right, centre or small", "'" + eye + "'"));
    if (!options.eyes.empty())
        return options.eyes;
    const auto present = [&](const std::string& eye) {
        return is_folder(options.picture / eye) || is_folder(options.truth / eye);
    };
    std::vector<std::string> eyes;
    for (const char* eye : {"left", "right"})
        if (present(eye))
            eyes.emplace_back(eye);
    if (eyes.empty() && present("centre"))
        eyes.emplace_back("centre");
    if (eyes.empty())
        eyes.emplace_back();
    return eyes;
}

std::vector<std::int64_t> choose_frames(const PairingOptions& options, const std::vector<Side>& sides) {
    std::vector<std::int64_t> wanted = sides.front().frames;
    if (options.first_frame) {
        wanted.resize(static_cast<std::size_t>(*options.last_frame - *options.first_frame + 1));
        std::iota(wanted.begin(), wanted.end(), *options.first_frame);
    }
    for (const Side& side : sides) {
        for (const std::int64_t frame : wanted)
            if (!side.holds(frame))
                throw InputError(expected_found(side.file(frame).string(), "a frame to compare", "no such file"));
        if (!options.first_frame && side.frames.size() != wanted.size())
            throw InputError(expected_found(side.place.string(),
                                            "the " + std::to_string(wanted.size()) + " frames of " +
                                                sides.front().place.string() + " (or give --frames)",
                                            std::to_string(side.frames.size()) + " frames"));
    }
    return wanted;
}

/// Builds one pair from the files of all sides, in the order of roots_of.
PicturePair make_pair(const PairingOptions& options, std::optional<std::int64_t> frame,
                      const std::vector<fs::path>& files) {
    PicturePair pair{frame, files[0], files[1], {}, {}, {}};
    std::size_t next = 2;
    if (options.second_picture) {
        pair.second_picture = files[next++];
        pair.second_truth = files[next++];
    }
    if (options.gaps)
        pair.gaps = files[next];
    return pair;
}

EyePairs pair_eye(const PairingOptions& options, const std::string& eye) {
    std::vector<Side> sides;
    for (const fs::path& root : roots_of(options))
        sides.push_back(open_side(eye.empty() ? root : root / eye));
    EyePairs eye_pairs{eye.empty() ? "view" : eye, {}};
    const auto files = std::count_if(sides.begin(), sides.end(), [](const Side& side) { return side.is_file(); });
    if (files != 0 && files != static_cast<std::ptrdiff_t>(sides.size()))
        throw InputError(expected_found(sides[0].place.string() + " and " + sides[1].place.string(),
                                        "files only or folders only", "a mixture"));
    std::vector<fs::path> paths;
    if (files != 0 && options.first_frame)
        throw InputError(expected_found("--frames", "folders of frames to choose from",
                                        "the single file " + sides[0].place.string()));
    if (files != 0) {
        for (const Side& side : sides)
            paths.push_back(side.place);
        eye_pairs.pairs.push_back(make_pair(options, std::nullopt, paths));
        return eye_pairs;
    }
    for (const std::int64_t frame : choose_frames(options, sides)) {
        paths.clear();
        for (const Side& side : sides)
            paths.push_back(side.file(frame));
        eye_pairs.pairs.push_back(make_pair(options, frame, paths));
    }
    return eye_pairs;
}

}  // namespace

std::vector<EyePairs> pair_pictures(const PairingOptions& options) {
    std::vector<EyePairs> eyes;
    for (const std::string& eye : choose_eyes(options))
        eyes.push_back(pair_eye(options, eye));
    return eyes;
}

}  // namespace equistream
