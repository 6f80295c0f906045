#pragma once
/// The two ways an eye's pixel finds its colour in a source; engines and fill passes are made of them.
#include "view.h"

namespace equistream {

struct ResampleOptions {
    double tolerance_rad = 0;                ///< e of the bound, for resample_by_surface
    PixelOrigin mark = PixelOrigin::source;  ///< what the pixels coloured here are marked with
    bool only_gaps = false;                  ///< leave alone what already has a colour
    /// For resample_by_surface: false colours every point whose direction the source has, whatever the source saw
    /// there; its depth is not read.
    bool only_seen = true;
};

/// By direction alone: positions and depth are ignored. Returns the number of pixels coloured.
std::int64_t resample_by_direction(const SourceView& source, const EyeView& eye, const ResampleOptions& options,
                                   EyePicture& picture);

/// By the point that the eye sees, where the source saw it too. Both views need depth.
std::int64_t resample_by_surface(const SourceView& source, const EyeView& eye, const ResampleOptions& options,
                                 EyePicture& picture);

}  // namespace equistream
