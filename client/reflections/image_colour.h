#pragma once
/// The colour of what mirrors and glass show, where a source has it.
#include "specular_sample.h"

#include <client/warp/sample_grid.h>
#include <client/warp/source_lookup.h>

#include <equistream/depth_agreement.h>

#include <algorithm>
#include <cmath>

namespace equistream {

/// References must outlive it; only reads, from any number of threads.
template <typename Lookup>
class ImageColour {
public:
    ImageColour(const Lookup& lookup, const SourceView& source, const DepthAgreement& agreement)
        : lookup_(lookup), source_(source), grid_(source), agreement_(agreement),
          wrapping_(source_grid(source.camera)) {}

    /// What is seen at a position found: of the four samples around, those that show the nearest one's image.
    Vec3f at(PixelPosition position) const {
        const BilinearCell cell(position);
        const Taps taps = lookup_.taps(position);
        const int near_x = position.u - 0.5f - float(cell.x) >= 0.5f;
        const int near_y = position.v - 0.5f - float(cell.y) >= 0.5f;
        const bool beside = joined(cell.x, cell.y + near_y, 1, 0), above = joined(cell.x + near_x, cell.y, 0, 1);
        const bool across = (beside && joined(cell.x + 1 - near_x, cell.y, 0, 1)) ||
                            (above && joined(cell.x, cell.y + 1 - near_y, 1, 0));
        float sum = 0;
        Vec3f colour;
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
        if (y < 0 || y >= wrapping_.height)
            return std::nanf("");
        return inverse_image(specular_sample(source_, formulas::wrapped_column(wrapping_, x, y), y));
    }

    /// Whether the neighbours at (x, y) and one step further show one image.
    bool joined(int x, int y, int dx, int dy) const {
        return agreement_.connected(inverse_image(x - dx, y - dy), inverse_image(x, y), inverse_image(x + dx, y + dy),
                                    inverse_image(x + 2 * dx, y + 2 * dy));
    }

    const Lookup& lookup_;
    const SourceView& source_;
    PictureGrid grid_;
    DepthAgreement agreement_;
    formulas::Wrapping wrapping_;
};

}  // namespace equistream
