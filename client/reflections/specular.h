#pragma once
/// Mirrors and glass. What they show does not lie on them: warped with the surface, it is displaced by up to
/// asin |w(v) - w(r)| (bound.h), r being the surface's distance and v that of the image in it.
///
/// A pixel that an engine took from a specular sample is kept where that is within the budget. Else it is looked up
/// anew by virtual depth: the eye's ray is searched for the point whose sample of the source has its image there (exact
/// for plane mirrors and thin panes). Where none is found the pixel is kept if its image is displaced by no more than a
/// degree. Else, and where virtual depth is not known and any image behind the surface might be displaced beyond the
/// budget, it becomes a gap. So it goes with MirrorTreatment::images; others are there to choose from.
#include <equistream/depth_agreement.h>
#include <equistream/virtual_image.h>

#include <client/warp/engine.h>
#include <client/warp/resample.h>
#include <client/warp/view.h>

#include <algorithm>
#include <cmath>
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
/// Throws InputError that names `option` and the accepted words.
MirrorTreatment find_mirror_treatment(std::string_view name, std::string_view option = "--mirrors");

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

// What one sample of a picture says of mirrors and glass.

/// Of a picture that has a mask.
struct SpecularSample {
    int x = 0, y = 0;
    bool specular = false;
};

inline SpecularSample specular_sample(const SourceView& source, int x, int y) {
    return {x, y, source.specular.pixel(x, y)[0] > min_specular};
}

/// Distance of the image that a sample shows, NaN where it is not known.
inline float image_distance(const SourceView& source, const SpecularSample& s) {
    if (source.virtual_depth_m.data == nullptr)
        return std::nanf("");
    const float distance_m = source.virtual_depth_m.pixel(s.x, s.y)[0];
    return distance_m > 0 ? std::min(distance_m, far_distance_m) : std::nanf("");
}

/// Whether an image at one distance, warped with a surface at another, stays within the budget; both as seen from the
/// picture's centre. An image whose distance nobody has told (NaN) lies somewhere from the surface to infinity.
inline bool warps_with_surface(const DepthAgreement& agreement, float surface_m, float image_m) {
    return std::abs((std::isnan(image_m) ? 0 : agreement.w(image_m)) - agreement.w(surface_m)) <= agreement.tolerance;
}

// The colour of what mirrors and glass show, where a source has it.

/// The source must outlive it; only reads, from any number of threads.
class ImageColour {
public:
    ImageColour(const SourceView& source, const DepthAgreement& agreement)
        : lookup_(source.camera), source_(source), grid_(source), agreement_(agreement) {}

    /// What is seen at a position found: of the four samples around, those that show the nearest one's image.
    glm::vec3 at(PixelPosition position) const {
        const BilinearCell cell(position);
        const Taps taps = lookup_.taps(position);
        const int near_x = position.u - 0.5f - float(cell.x) >= 0.5f;
        const int near_y = position.v - 0.5f - float(cell.y) >= 0.5f;
        const bool beside = joined(cell.x, cell.y + near_y, 1, 0), above = joined(cell.x + near_x, cell.y, 0, 1);
        const bool across = (beside && joined(cell.x + 1 - near_x, cell.y, 0, 1)) ||
                            (above && joined(cell.x, cell.y + 1 - near_y, 1, 0));
        float sum = 0;
        glm::vec3 colour(0);
        for (int k = 0; k < 4; ++k) {
            const bool far_x = (k & 1) != near_x, far_y = (k >> 1) != near_y;
            if ((far_x && far_y && !across) || (far_x && !far_y && !beside) || (far_y && !far_x && !above))
                continue;
            sum += taps.weight[k];
            colour = colour + grid_.colour({taps.x[k], taps.y[k]}) * taps.weight[k];
        }
        return colour * (1 / sum);
    }

private:
    /// 1 / distance; NaN where a sample shows no image, or nobody has told where it lies.
    float inverse_image(const SpecularSample& s) const {
        return s.specular ? 1 / image_distance(source_, s) : std::nanf("");
    }
    float inverse_image(int x, int y) const {
        if (y < 0 || y >= lookup_.grid().height)
            return std::nanf("");
        return inverse_image(specular_sample(source_, formulas::wrapped_column(lookup_.grid(), x, y), y));
    }

    /// Whether the neighbours at (x, y) and one step further show one image.
    bool joined(int x, int y, int dx, int dy) const {
        return agreement_.connected(inverse_image(x - dx, y - dy), inverse_image(x, y), inverse_image(x + dx, y + dy),
                                    inverse_image(x + 2 * dx, y + 2 * dy));
    }

    SourceLookup lookup_;
    const SourceView& source_;
    PictureGrid grid_;
    DepthAgreement agreement_;
};

}  // namespace equistream
