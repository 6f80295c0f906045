#pragma once
/// What the risks of one eye's pixels are computed from: numbers that hold for the whole picture.
#include <client/reflections/specular_sample.h>
#include <client/warp/float_math.h>
#include <plugin/formulas/scalars.h>

#include "reliability.h"

namespace equistream {

using formulas::max_halvings;
inline constexpr float twentieths = 20;
/// Of a tenth of a millimetre: squares of it and of what is made of it stay finite.
inline constexpr float max_inverse_m = 1e4f;

/// What holds for the whole picture.
struct RiskNumbers {
    RiskNumbers(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                const ReliabilityOptions& options);
    /// Without depth_m, which may lie where no view reaches.
    RiskNumbers(const SourceView& source, const EyeView& eye, bool has_depth, const ReliabilityOptions& options);

    ImageView<const float> depth_m;  ///< of the eye; empty where it is not known
    Vec3f centre;                    ///< of the source in the eye's axes, metres
    Vec3f pole;                      ///< of the source's rows in the eye's axes; 0 where its columns do not converge
    float baseline_m = 0;            ///< from the source to the eye
    float focal_px = 1;
    float density = 1;                    ///< source pixels per radian over the eye's at its middle
    float outside = 0;                    ///< radii beyond the head box
    float depth_error_px = 0;             ///< by which the depth's tolerance displaces a pixel
    CodingLoss coding_loss;               ///< zeros where nothing was coded
    int step = 1;                         ///< a source pixel, in pixels of the eye
    int texture_reach = 4;                ///< pixels to either side that Risk::texture is a mean over
    float min_step_inverse_m = 0;         ///< of inverse planar depth, at a silhouette
    bool mirrors = false;                 ///< the source's specular mask counts
    KnownDepth known = KnownDepth::fine;  ///< an eye that has not moved needs none

    bool has_depth() const { return depth_m.data != nullptr; }
};

/// Whether the eye looks through the source's very camera, so that nothing was resampled.
bool same_view(const SourceView& source, const EyeView& eye);

}  // namespace equistream
