#include "eye_steps.h"

namespace equistream {

EyeSteps::EyeSteps(std::string_view engine, const EngineOptions& options, MirrorTreatment mirrors)
    : engine_(make_engine(engine, options)), error_budget_px_(options.error_budget_px), mirrors_(mirrors) {}

void EyeSteps::set_source(const SourceView& source) {
    source_ = source;
    engine_->set_source(source_);
}

SpecularCounts EyeSteps::reproject(const EyeView& eye, EyePicture& picture) const {
    engine_->reproject(eye, picture);
    return rework_specular(source_, eye, picture, {.error_budget_px = error_budget_px_, .treatment = mirrors_});
}

void EyeSteps::judge(const EyeView& eye, EyePicture& picture, const ReliabilityOptions& known) const {
    estimate_reliability(source_, eye, picture, known);
}

}  // namespace equistream
