#pragma once
/// The steps that turn a source picture into what one eye sees, on the CPU: reproject, rework reflections, judge. Gaps
/// are filled in between (fill.h). `play`, Python and the client library all take these.
#include "left_windows.h"

#include <client/confidence/reliability.h>
#include <client/fill/fill.h>
#include <client/receive/receive.h>
#include <client/reflections/specular.h>
#include <client/warp/engine.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace equistream {

class EyeSteps {
public:
    EyeSteps(std::string_view engine, const EngineOptions& options, MirrorTreatment mirrors);

    const Engine& engine() const { return *engine_; }
    /// Borrows the view's pixels until the next call.
    void set_source(const SourceView& source);
    /// Colours, gaps and reflections of one eye. Any number of threads, each with a picture of its own.
    SpecularCounts reproject(const EyeView& eye, EyePicture& picture) const;
    /// Confidence of a picture whose gaps were filled.
    void judge(const EyeView& eye, EyePicture& picture, const ReliabilityOptions& known) const;
    const SourceView& source() const { return source_; }
    MirrorTreatment mirrors() const { return mirrors_; }

private:
    std::unique_ptr<Engine> engine_;
    double error_budget_px_;
    MirrorTreatment mirrors_;
    SourceView source_;
};

// What became of one eye's pixels.

struct EyeFigures {
    std::int64_t pixels = 0;
    std::int64_t gaps = 0;                ///< what the source did not see
    SpecularCounts specular{};            ///< mirrors and glass
    FilledCounts filled{};                ///< by each pass, in order
    std::optional<double> reliability{};  ///< the pixels' mean, 0 to 1, where it was estimated
};

// The fill chain of a run and what it fills from: pictures that came with the frame, those of frames before, and the
// client's own geometry.

/// Depths of pictures that came without; empty where nothing needed them.
struct SourceDepths {
    FloatImage main, right, base, small, patches;
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
        BaseEngine* base_engine = nullptr;  ///< takes the base, where there is one
    };
    /// Takes what there is of a frame, borrowed until the next one. Pictures have the sizes that they are tagged with.
    void set_frame(const ReceivedFrame& frame, const SourceDepths& depths, const Shown& shown);
    FilledCounts fill(const EyeView& eye, EyePicture& picture) const { return fill_gaps(chain_, eye, picture); }
    /// Keeps a frame's main picture for the next frame, where a fill pass asks for it; `depths` gets the memory of what
    /// is kept no longer. `base`: the sphere around it, where it is a window; else null. Windows stay for
    /// longer once the gaze has left them.
    void remember(std::shared_ptr<const ReceivedPicture> main, std::shared_ptr<const ReceivedPicture> base,
                  SourceDepths& depths);
    /// The frames that the fill chain before this one kept.
    void take_over(FrameFill& before);
    /// As if no frame had been kept.
    void forget() {
        earlier_.reset();
        left_windows_.clear();
    }

private:
    struct Earlier {
        std::shared_ptr<const ReceivedPicture> picture, base;
        FloatImage depth_m;

        const Camera& camera() const { return picture->info.camera; }
        double time_s() const { return picture->info.time_s; }
    };
    /// `base`: by which it shows where light has changed since; null: nobody asks.
    void show_earlier(const Earlier& earlier, const ReceivedPicture* base);
    FloatImage leave(Earlier earlier);

    FillChain chain_;
    bool has_earlier_pass_ = false;
    GeometryColour* geometry_;
    std::optional<Earlier> earlier_;
    LeftWindows<Earlier> left_windows_;
    // Views of the frame at hand.
    std::optional<SourceView> main_, base_, small_, hidden_;
    std::optional<PatchesView> patches_;
    std::vector<SourceView> earlier_views_, earlier_bases_;
};

}  // namespace equistream
