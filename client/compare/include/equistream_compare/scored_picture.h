#pragma once
/// Pictures on disk as the metrics want them: 8-bit display-referred, or linear after exposure.
/// PNG holds 8-bit display-referred sRGB. EXR holds scene-linear radiance, which gets the exposure of its frame and
/// the display transform. Functions throw InputError naming the file: a picture is always input here.
#include <equistream/colour.h>
#include <equistream/frame.h>

#include <filesystem>
#include <optional>

namespace equistream {

struct ScoredPicture {
    std::filesystem::path file;
    bool linear = false;            ///< an EXR: `samples` is scene-linear radiance; otherwise display values in [0, 1]
    FloatImage samples;             ///< 3 or 4 channels where linear, 3 otherwise
    double exposure = 1;            ///< factor on radiance before the display transform; 1 where not linear
    std::optional<FrameInfo> info;  ///< EXR only
};

/// Reads a .png (gray becomes RGB, alpha is ignored) or the plane "colour" of an .exr. `exposure` replaces the EXR
/// frame's own.
ScoredPicture read_scored_picture(const std::filesystem::path& file, std::optional<double> exposure = {});

/// Display-referred values in [0, 1], not rounded to 8 bits.
FloatImage display_values(const ScoredPicture& picture, const DisplayTransform& transform);
/// Radiance times exposure, clipped to [0, 1]: what the default view can show.
FloatImage exposed_linear(const ScoredPicture& picture, const DisplayTransform& transform);

/// Reads a mask of one channel: 255 where any colour channel of the PNG is not 0, else 0.
ByteImage read_mask(const std::filesystem::path& file);

}  // namespace equistream
