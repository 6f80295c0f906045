#pragma once
/// Which picture is compared with which: folders with one subfolder per eye, folders of frames, or single files.
#include <equistream/colour.h>
#include <equistream/frame.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

struct PairingOptions {
    std::filesystem::path picture;
    std::filesystem::path truth;
    std::optional<std::filesystem::path> second_picture;  ///< only with a second truth
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
    std::filesystem::path second_truth;    ///< empty without a second truth
    std::filesystem::path gaps;            ///< empty without masks
};

struct EyePairs {
    std::string eye;  ///< "left", "right", "centre", "small"; "view" for a bare folder of frames or a file
    std::vector<PicturePair> pairs;
};

/// Throws InputError in one line where a side lacks an eye or a frame that another has. Without a frame range all
/// sides must hold the same frames.
std::vector<EyePairs> pair_pictures(const PairingOptions& options);

// Pictures on disk as the metrics want them: 8-bit display-referred, or linear after exposure.
// PNG holds 8-bit display-referred sRGB. EXR holds scene-linear radiance, which gets the exposure of its frame and
// the display transform. Functions throw InputError naming the file: a picture is always input here.

struct ScoredPicture {
    std::filesystem::path file;
    bool linear = false;            ///< an EXR
    FloatImage radiance;            ///< where linear: scene-linear, 3 or 4 channels
    ByteImage rgb;                  ///< where not: display values, 3 channels
    double exposure = 1;            ///< factor on radiance before the display transform; 1 where not linear
    std::optional<FrameInfo> info;  ///< EXR only
    FloatImage backward, forward;   ///< motion planes, where they were asked for and are there

    int width() const { return linear ? radiance.width() : rgb.width(); }
    int height() const { return linear ? radiance.height() : rgb.height(); }
};

/// Reads a .png (gray becomes RGB, alpha is ignored) or the plane "colour" of an .exr, and its motion if asked for.
/// `exposure` replaces the EXR frame's own.
ScoredPicture read_scored_picture(const std::filesystem::path& file, std::optional<double> exposure = {},
                                  bool with_motion = false);

/// Display-referred values in [0, 1], not rounded to 8 bits.
FloatImage display_values(const ScoredPicture& picture, const DisplayTransform& transform);
/// Display values in 8 bits: a PNG's own, else those of `made`, which they are put into.
ImageView<const std::uint8_t> display_8bit(const ScoredPicture& picture, const DisplayTransform& transform,
                                           ByteImage& made);
/// Radiance times exposure, clipped to [0, 1]: what the default view can show.
FloatImage exposed_linear(const ScoredPicture& picture, const DisplayTransform& transform);

/// Reads a mask of one channel: 255 where any colour channel of the PNG is not 0, else 0.
ByteImage read_mask(const std::filesystem::path& file);

}  // namespace equistream
