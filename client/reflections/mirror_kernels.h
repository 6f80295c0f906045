#pragma once
/// The inner loops of rework_specular (specular.h), for every instruction set that Highway compiles them for; the one
/// that this processor has is picked when they run. tests/support/references/mirrors.cpp says
/// in plain words what they compute.
#include <client/warp/resample.h>
#include <client/warp/view.h>
#include <equistream/depth_agreement.h>

#include "specular.h"

#include <cstdint>
#include <vector>

namespace equistream {

/// One eye whose pixels an engine took from one source, which has depth and a mask, and virtual depth if it is known.
struct MirrorJob {
    SourceGrid grid;
    const SourceView& source;
    const EyeView& eye;  ///< with depth of what its pixels show
    EyeRays rays;
    ImageView<const std::uint8_t> origin;
    DepthAgreement agreement;
    bool looks_for_images = true;  ///< false: what is not known to be within the budget is a gap
};

/// Sine of 1 degree. Where no image is found, a colour displaced by less is mostly nearer the truth than what would
/// fill the gap, one displaced by more is not (docs/decisions/0004).
inline constexpr float max_image_displacement = 0.01745f;
/// Points along an eye's ray that are looked at for its image, at most; and rounds of moving from there onto it.
inline constexpr int max_image_steps = 64, max_image_turns = 24;

enum class MirrorAnswer : std::uint8_t {
    kept,       ///< within the budget
    by_image,   ///< its colour is at a position found
    displaced,  ///< no image found, displaced by little
    gap,
};

/// Pixels of one row whose nearest sample is a mirror's, from left to right.
struct MirrorRow {
    explicit MirrorRow(int width);

    int count = 0;
    std::vector<std::int32_t> x;
    std::vector<std::uint8_t> answer;  ///< MirrorAnswer
    std::vector<float> u, v;           ///< by_image: where the source has it
};

/// Any number of threads, each its own rows.
void find_images(const MirrorJob& job, int y, MirrorRow& row);

/// rework_specular with any finder of a row's images: that is find_images.
using ImageFinder = void(const MirrorJob& job, int y, MirrorRow& row);
SpecularCounts rework_specular_by(ImageFinder* find, const SourceView& source, const EyeView& eye, EyePicture& picture,
                                  const SpecularOptions& options);

}  // namespace equistream
