#pragma once
/// The fill chain of a run and what it fills from: pictures that came with the frame, those of frames before, and the
/// client's own geometry.
#include <client/fill/fill.h>
#include <client/receive/receive.h>

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace equistream {

/// Depths of pictures that came without; empty where nothing needed them.
struct SourceDepths {
    FloatImage main, small, patches;
};

bool has_pass(const FillChain& chain, std::string_view name);

class FrameFill {
public:
    /// `geometry` is for the fill pass of that name; null: it fills nothing. Borrowed.
    FrameFill(const std::string& passes, GeometryColour* geometry);
    ~FrameFill();

    /// Whether some fill pass is better with depth of pictures and eyes.
    bool wants_depth() const;
    bool has(std::string_view fill_pass) const;
    bool takes_small() const;
    /// The main picture as eyes see it: its own, or extrapolated to a later time.
    struct Shown {
        SourceView main;
        double time_s = 0;
    };
    /// Takes what there is of a frame, borrowed until the next one.
    void set_frame(const ReceivedFrame& frame, const SourceDepths& depths, const Shown& shown);
    FilledCounts fill(const EyeView& eye, EyePicture& picture) const { return fill_gaps(chain_, eye, picture); }
    /// Keeps a frame's main picture for the frames to come, where a fill pass asks for it; `depths` gets the memory of
    /// those that are kept no longer.
    void remember(std::shared_ptr<const ReceivedPicture> main, SourceDepths& depths);
    /// The frames that the fill chain before this one kept.
    void take_over(FrameFill& before);
    /// As if no frame had been kept.
    void forget() { earlier_.clear(); }

private:
    struct Earlier {
        std::shared_ptr<const ReceivedPicture> picture;
        FloatImage depth_m;
    };

    FillChain chain_;
    bool has_earlier_pass_ = false;
    GeometryColour* geometry_;
    std::deque<Earlier> earlier_;  ///< newest first
    // Views of the frame at hand.
    std::optional<SourceView> main_, small_, hidden_;
    std::optional<PatchesView> patches_;
    std::vector<SourceView> earlier_views_;
};

}  // namespace equistream
