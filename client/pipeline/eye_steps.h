#pragma once
/// The steps that turn a source picture into what one eye sees, on the CPU: reproject, rework reflections, judge. Gaps
/// are filled in between (fill.h). `play`, Python and the client library all take these.
#include <client/confidence/reliability.h>
#include <client/reflections/specular.h>
#include <client/warp/engine.h>

#include <memory>
#include <string_view>

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

}  // namespace equistream
