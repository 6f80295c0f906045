#pragma once
/// How far each pixel of an eye's picture can be trusted: the probability that none of its channels differs from the
/// true eye's by more than reliability_tolerance. Estimated from what the client has anyway; calibrated on rendered
/// pairs (docs/results/reproject/reliability.md).
///
/// The model: each pixel has risks, none of which is negative. Their weighted sum, with weights that are not negative
/// either, lowers the logit of the probability; a table that falls with the sum then makes it the share that was
/// measured. So more of any risk never makes a pixel more trustworthy. Weights and table depend on who gave the pixel
/// its colour. What noise, denoising and coding did to the source comes on top: the probability is multiplied by
/// kept_share (risks.glsl.h) of how many of the source's pixels they put visibly off where there is as much texture
/// (VisibleLoss). All functions are pure and use all cores.
#include <equistream/visible_loss.h>

#include <client/warp/eye_rays.h>
#include <client/warp/view.h>
#include <plugin/formulas/scalars.h>

#include <array>
#include <optional>
#include <string_view>

namespace equistream {

/// Of 255, in the worst channel of a display-referred picture.
inline constexpr int reliability_tolerance = visible_loss_255;

/// Risks, in the order of reliability_risks' channels. log is log2(1 + x).
enum class Risk {
    contrast,      ///< log of the worst channel's difference to the picture one source pixel away, in 1/2 of 1/255
    detail,        ///< log of the largest difference of the pixel, or of those one source pixel around it, to the mean
                   ///< of the pictures one source pixel to either side, in 1/2 of 1/255
    texture,       ///< log of contrast's mean over nine source pixels by nine, in 1/2 of 1/255
    blur,          ///< detail, for each halving of the source's pixels per eye pixel below one, the mean of rows and
                   ///< columns (a sphere's columns draw together towards its poles)
    minification,  ///< detail, for each doubling above one
    grazing,       ///< detail, for each halving of the cosine between ray and normal, at most four
    silhouette_0,  ///< 1 at a silhouette or at a pixel beside one of another origin
    silhouette_1,  ///< 1 up to one pixel from there
    silhouette_2,  ///< 1 up to two pixels
    parallax,      ///< log of the pixels by which the eye sees the point displaced from where the source does
    specular,      ///< of group mirrored: log of contrast in 1/2 of 1/255, times parallax in pixels where that is below
                   ///< one (what is mirrored may be displaced by that; beyond a pixel it shows something else)
    depth_error,   ///< log of how much the depth's tolerance may displace the pixel, times contrast in 1/255
    outside,       ///< how far the eye is out of the head box, in radii, at most two
    fill_depth,    ///< log of the distance into a filled region, in pixels
    brightness,    ///< of the brightest channel, 0 to 1: errors in the dark are small
};
inline constexpr int risk_count = 15;
inline constexpr std::array<std::string_view, risk_count> risk_names = {
    "contrast",     "detail",   "texture",  "blur",        "minification", "grazing",    "silhouette_0", "silhouette_1",
    "silhouette_2", "parallax", "specular", "depth_error", "outside",      "fill_depth", "brightness"};

/// Whose weights a pixel takes.
enum class RiskGroup {
    source,    ///< looked up in the source by depth that its tolerance displaces by no more than its share of the bound
    coarse,    ///< the same by coarser depth
    seen,      ///< looked up by depth elsewhere at the source's density: origins earlier, patches, hidden
    small,     ///< looked up by depth in the small view
    guessed,   ///< made from other pixels or from geometry without its light: neighbours, push_pull, geometry
    turned,    ///< origin source, from another position and with no depth known: direction only
    mirrored,  ///< looked up by the depth of a mirror or a pane, which is not the depth of what is seen in it
};
inline constexpr int risk_group_count = 7;
inline constexpr std::array<std::string_view, risk_group_count> risk_group_names = {
    "source", "coarse", "seen", "small", "guessed", "turned", "mirrored"};

struct ReliabilityOptions {
    /// By how much w = B / (r - B) of the depth that was used may be off (bound.h): the most that a depth code changes.
    double depth_tolerance_w = 0;
    /// How visibly off the source's colours are (visible_loss_of the main track's frame data); nothing: not known, or
    /// not at all. Stands for what gaps are filled from too.
    std::optional<VisibleLoss> visible_loss{};
    /// rework_specular (specular.h) has been over the picture: what it left of mirrors lies within the bound.
    bool specular_reworked = false;
};

/// Fills `picture.reliability` for a finished picture (origin and rgba as engine and fill passes left them). Depth of
/// the eye is `eye.depth_m`, else `picture.depth_m`; without both, of a moved eye, the group is `turned`. Gaps that are
/// left get 0; a pixel of the source's very view gets 255, less what its source lost. InputError where a picture's, the
/// depth's or the specular mask's size is not that of its camera, here and below.
void estimate_reliability(const SourceView& source, const EyeView& eye, EyePicture& picture,
                          const ReliabilityOptions& options = {});

/// The risks alone, risk_count channels; what the model is fitted to.
FloatImage reliability_risks(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options = {});

/// The risks' group of each pixel, 1 channel; no_risk_group for gaps.
ByteImage reliability_groups(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options = {});
inline constexpr std::uint8_t no_risk_group = 255;

/// What is known of the depth that pixels of origin source were looked up by.
enum class KnownDepth { none, coarse, fine };

/// Group of a pixel; not of gaps. `mirrored` counts where depth looked it up in the source.
RiskGroup risk_group(PixelOrigin origin, KnownDepth depth, bool mirrored = false);

// What the risks of one eye's pixels are computed from: numbers that hold for the whole picture.

using formulas::max_halvings;
/// Of a tenth of a millimetre: squares of it and of what is made of it stay finite.
inline constexpr float max_inverse_m = 1e4f;

/// What holds for the whole picture.
struct RiskNumbers {
    RiskNumbers(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                const ReliabilityOptions& options);
    /// Without depth_m, which may lie where no view reaches.
    RiskNumbers(const SourceView& source, const EyeView& eye, bool has_depth, const ReliabilityOptions& options);

    ImageView<const float> depth_m;  ///< of the eye; empty where it is not known
    glm::vec3 centre{0};             ///< of the source in the eye's axes, metres
    glm::vec3 pole{0};               ///< of the source's rows in the eye's axes; 0 where its columns do not converge
    float baseline_m = 0;            ///< from the source to the eye
    float focal_px = 1;
    float density = 1;                    ///< source pixels per radian over the eye's at its middle
    float outside = 0;                    ///< radii beyond the head box
    float depth_error_px = 0;             ///< by which the depth's tolerance displaces a pixel
    VisibleLoss visible_loss;             ///< zeros where it is not known
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
