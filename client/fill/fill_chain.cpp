#include "fill.h"

namespace equistream {

FilledCounts fill_gaps(const FillChain& chain, const EyeView& eye, EyePicture& picture) {
    FilledCounts filled;
    Gaps gaps(picture.origin.view());
    for (const auto& pass : chain)
        filled.emplace_back(pass->name(), pass->fill(eye, picture, gaps));
    return filled;
}

}  // namespace equistream
