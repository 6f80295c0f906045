#pragma once
/// Mirrors and glass. What they show does not lie on them: warped with the surface, it is displaced by up to
/// asin |w(v) - w(r)| (bound.h), r being the surface's distance and v that of the image in it.
///
/// A pixel that an engine took from a specular sample is kept where that is within the budget. Else it is looked up
/// anew by virtual depth: the eye's ray is searched for the point whose sample of the source has its image there (exact
/// for plane mirrors and thin panes). Where none is found the pixel is kept if its image is displaced by no more than a
/// degree. Else, and where virtual depth is not known and any image behind the surface might be displaced beyond the
/// budget, it becomes a gap. So it goes with MirrorTreatment::images; others are there to choose from.
#include <client/warp/engine.h>

#include <span>
#include <string_view>

namespace equistream {

/// What becomes of mirrors and glass.
enum class MirrorTreatment {
    images,   ///< as above
    gaps,     ///< a gap wherever virtual depth does not tell that the image warps with its surface, as in the paper
    surface,  ///< nothing: they stay as the engine took them, as if painted on their surface
};

/// By the values of MirrorTreatment.
std::span<const std::string_view> mirror_treatment_names();
/// InputError, as of an option --mirrors, if there is none of that name.
MirrorTreatment find_mirror_treatment(std::string_view name);

struct SpecularCounts {
    std::int64_t kept = 0;       ///< within the budget as they were
    std::int64_t by_image = 0;   ///< looked up by virtual depth
    std::int64_t displaced = 0;  ///< kept, beyond the budget by less than a degree, for want of an image
    std::int64_t gaps = 0;

    SpecularCounts& operator+=(const SpecularCounts& other) {
        kept += other.kept;
        by_image += other.by_image;
        displaced += other.displaced;
        gaps += other.gaps;
        return *this;
    }
    std::int64_t all() const { return kept + by_image + displaced + gaps; }
};

struct SpecularOptions {
    double error_budget_px = EngineOptions{}.error_budget_px;
    MirrorTreatment treatment = MirrorTreatment::images;
};

/// After an engine's reproject. The source needs depth and a specular mask, the eye or its picture depth; without them
/// nothing is done, nor by MirrorTreatment::surface. Otherwise InputError where mask, depth or virtual depth are not of
/// the camera's size.
SpecularCounts rework_specular(const SourceView& source, const EyeView& eye, EyePicture& picture,
                               const SpecularOptions& options = {});

}  // namespace equistream
