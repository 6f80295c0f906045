#pragma once
/// The fill chain: what each fill pass does to the pixels that the source did not see. Fill passes run in order; each
/// touches only pixels whose origin is gap, and marks those it fills.
///
/// `hidden`    the source's second layer: what lies behind the first surface along the same rays.
/// `patches`   blocks of spheres beside the source's that the server predicted the eyes to need.
/// `base`      the coarse sphere around a window: all that lies beyond the window's border, as the engine shows the
///             sphere alone. Along the border both are mixed, so that it is not seen. Gaps within are filled too, but
///             for those of mirrors. Nothing is done where only the window is in view.
/// `earlier`   earlier main pictures, and windows that the gaze has left. A sample counts only where its surface is
///             still the same by depth agreement: what moved since is refused. So is a window that the gaze has left
///             where the base has another colour by now. (Streams carry no motion, so nothing is carried along with an
///             object, and what slides within its own surface, a shadow or a picture on a screen, is not noticed.)
/// `small`     the small second-eye view. Exact in position for the eye it was rendered from; the other eye gets what
///             that eye sees too.
/// `small-wide` the same, but only in gaps that hold a square half as wide as one of its pixels.
/// `geometry`  the client's own geometry: its base colour, lit as the filled pixels of the same surface around are.
/// `pushpull`  coarser and coarser levels of the picture itself (Gortler et al. 1996, "The lumigraph", section 3.4.2),
///             kept apart by depth: a gap takes the colour of its own surface, or of the background where the gap's
///             depth is not known, so that what is in front does not bleed into what it uncovered.
/// `spread`    the nearest filled neighbours, layer by layer, those at the pixel's own depth before others.
///
/// All but `base` and the last three look up the point that a gap pixel sees in a picture that was rendered elsewhere;
/// of the four samples around it only those on the same surface count (depth_agreement.h). What a gap pixel sees is
/// known from the eye's depth; where there is none, the picture's own samples are drawn forward into the gaps, nearest
/// first. Pictures without depth are looked up by direction alone (`small`, `small-wide`), or not at all.
#include "gaps.h"

#include <client/depth/depth_source.h>
#include <client/warp/engine.h>
#include <client/warp/view.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace equistream {

struct PatchAtlas;

/// Two spheres of 8 bits that differ by more show other light: what coding and noise make of the same is less.
inline constexpr float changed_light = 24;
/// A window and the sphere around it are mixed by so many steps along the border.
inline constexpr int window_mix_steps = 256;

/// One picture that holds all patches of a frame (patches.h).
struct PatchesView {
    ImageView<const std::uint8_t> rgb{};  ///< as in SourceView, of the atlas' size
    YuvView yuv{};
    ImageView<const float> depth_m{};  ///< radial distance from each patch's own position, NaN where there is nothing
    const PatchAtlas* atlas = nullptr;
    Pose pose{};              ///< of the sphere that the patches belong to
    double box_radius_m = 0;  ///< its head box, as in SourceView
};

/// What eyes see of the sphere around a window alone, by the engine that shows the window.
class BaseEngine {
public:
    BaseEngine(std::string_view engine, const EngineOptions& options);

    /// Borrows the view's pixels until the next call. The engine takes them when it is first asked for a picture.
    void set_base(const SourceView& base);
    /// As Engine's, from any number of threads. By direction alone where the engine needs depth and the base has none.
    void reproject(const EyeView& eye, EyePicture& picture) const;

private:
    std::unique_ptr<Engine> engine_;
    SourceView base_;
    mutable std::mutex mutex_;
    mutable bool is_source_ = false;
};

/// What a frame brings to fill gaps with, borrowed until the next frame; what is not there is null or empty.
struct FillInputs {
    const SourceView* main = nullptr;
    const SourceView* small = nullptr;
    const SourceView* base = nullptr;  ///< the sphere around main, where that is a window
    /// Of `base`; null: it is looked up by direction alone.
    const BaseEngine* base_engine = nullptr;
    std::span<const SourceView> earlier{};  ///< main pictures of frames before, newest first, with depth
    /// The spheres around windows that the gaze has left: by these it shows where light has changed. Empty, or as many,
    /// without colours for the others.
    std::span<const SourceView> earlier_bases{};
    const SourceView* hidden = nullptr;  ///< camera and pose of main; depth_m NaN where there is no second surface
    const PatchesView* patches = nullptr;
    GeometryColour* geometry = nullptr;
    /// As in EngineOptions: what a fill pass takes from elsewhere for a point is no farther from it than this.
    /// `geometry` and `spread` have no use for it.
    double error_budget_px = EngineOptions{}.error_budget_px;
};

class FillPass {
public:
    FillPass(std::string_view name, bool wants_depth) : name_(name), wants_depth_(wants_depth) {}
    virtual ~FillPass() = default;
    std::string_view name() const { return name_; }
    /// Whether depth of the views this fill pass takes its colours from, and of the eye, makes it better.
    bool wants_depth() const { return wants_depth_; }
    /// A fill pass whose input is missing fills nothing.
    virtual void set_frame(const FillInputs& inputs) { inputs_ = inputs; }
    /// Fills gaps of `picture`, which shows `eye`; `gaps` are all its gaps, and those that stay open when it returns.
    /// Where the picture has depths of its own, those of filled pixels are set too. Returns how many pixels it filled.
    /// Any number of threads may fill pictures of their own at once.
    virtual std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const = 0;

    /// The same where nobody keeps the gaps.
    std::int64_t fill(const EyeView& eye, EyePicture& picture) const {
        Gaps gaps(picture.origin.view());
        return fill(eye, picture, gaps);
    }

protected:
    FillInputs inputs_;

private:
    std::string_view name_;
    bool wants_depth_;
};

/// Fill passes in the order in which they run.
using FillChain = std::vector<std::unique_ptr<FillPass>>;

/// Pixels filled, by the fill passes' names and in their order.
using FilledCounts = std::vector<std::pair<std::string, std::int64_t>>;

/// Runs a fill chain whose fill passes have been given their frame.
FilledCounts fill_gaps(const FillChain& chain, const EyeView& eye, EyePicture& picture);

/// What shows what is truly there, then push-pull (docs/decisions/0004).
inline constexpr const char* default_fill = "hidden,patches,earlier,base,pushpull";

/// Fill passes of a comma-separated list of names of fill_stages() (stages.h); "none" alone is an empty fill chain.
/// Throws InputError naming the accepted words.
FillChain make_fill_chain(const std::string& list);

}  // namespace equistream
