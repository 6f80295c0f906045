#pragma once
/// The engines and the rework of mirrors in plain words: double precision, one pixel after the other, through the
/// public cameras. Tests hold the product's own to them; nothing else links them.
#include <client/confidence/reliability.h>
#include <client/reflections/specular.h>
#include <client/warp/engine.h>
#include <client/warp/view.h>

namespace equistream::plain {

/// Of the same name and options as equistream::make_engine's.
std::unique_ptr<Engine> make_engine(std::string_view name, const EngineOptions& options = {});

/// As equistream::rework_specular.
SpecularCounts rework_specular(const SourceView& source, const EyeView& eye, EyePicture& picture,
                               const SpecularOptions& options = {});

// The reliability map in plain words (client/confidence/reliability.h), one pixel after the other.

/// As equistream's of the same names.
void estimate_reliability(const SourceView& source, const EyeView& eye, EyePicture& picture,
                          const ReliabilityOptions& options = {});
FloatImage reliability_risks(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options = {});
ByteImage reliability_groups(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options = {});

/// The model itself, for one pixel's risks: from 0 to 1.
float reliability_of(RiskGroup group, const std::array<float, risk_count>& risks);

// What lies around each pixel of an eye's picture: silhouettes, edges between origins, the way out of filled regions.

/// 3 on a pixel beside a silhouette or beside one of another origin, and one less for each pixel (of eight neighbours)
/// away from there: 3, 2, 1, else 0. A silhouette is where w = B / (r - B) steps by more than `step_w` and by more
/// than twice what the slopes on either side would have it. `inverse_planar` may be empty.
ByteImage silhouette_closeness(const FloatImage& inverse_planar, const ByteImage& origin, float step_inverse_m);

/// 0 where the origin is the source; elsewhere pixels along the row or column to the nearest that is, at most 255.
ByteImage fill_depth(const ByteImage& origin);

/// Differences of a picture's pixels, in the worst channel, in 1/255.
struct Differences {
    ByteImage contrast;  ///< contrast_of (visible_loss.h)
    /// The largest to the mean of two of them that face each other: of the pixel and of the eight around it at that
    /// step. (In the middle of an edge that a coarse source has spread the pixel is that mean; beside it it is not.)
    ByteImage detail;
};
Differences differences(const ByteImage& rgba, int step);

}  // namespace equistream::plain
