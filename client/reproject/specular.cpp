#include <equistream_client/specular.h>

#include "specular_look_up.h"

#include <equistream/bound.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>

namespace equistream {

namespace {

template <typename Lookup>
SpecularCounts rework_all(const SpecularLookUp<Lookup>& mirrors, ImageView<const float> depth_m, EyePicture& picture) {
    using Answer = typename SpecularLookUp<Lookup>::Answer;
    SpecularCounts total;
    std::mutex mutex;
    tbb::parallel_for(tbb::blocked_range<int>(0, depth_m.height, 8), [&](const tbb::blocked_range<int>& rows) {
        SpecularCounts counts;
        for (int y = rows.begin(); y < rows.end(); ++y)
            for (int x = 0; x < depth_m.width; ++x) {
                std::uint8_t* origin = picture.origin.pixel(x, y);
                if (*origin != std::uint8_t(PixelOrigin::source))
                    continue;
                const Answer answer = mirrors.look(x, y, *depth_m.pixel(x, y), picture.rgba.pixel(x, y));
                counts.kept += answer == Answer::kept;
                counts.by_image += answer == Answer::by_image;
                if (answer != Answer::gap)
                    continue;
                ++counts.gaps;
                *origin = std::uint8_t(PixelOrigin::gap);
                std::fill_n(picture.rgba.pixel(x, y), 4, std::uint8_t{0});
                if (!picture.depth_m.empty())
                    *picture.depth_m.pixel(x, y) = std::nanf("");
            }
        const std::scoped_lock lock(mutex);
        total = {total.kept + counts.kept, total.by_image + counts.by_image, total.gaps + counts.gaps};
    });
    return total;
}

}  // namespace

SpecularCounts rework_specular(const SourceView& source, const EyeView& eye, double error_budget_px,
                               EyePicture& picture) {
    const bool own = eye.depth_m.data == nullptr && !picture.depth_m.empty();
    const ImageView<const float> depth_m = own ? picture.depth_m.view() : eye.depth_m;
    if (source.specular.data == nullptr || source.depth_m.data == nullptr || depth_m.data == nullptr)
        return {};
    const double budget_rad = 4 * error_budget_px * error_budget_rad(eye.camera.focal_px());
    return with_lookup(source.camera, [&](const auto& lookup) {
        return rework_all(SpecularLookUp(lookup, source, eye, budget_rad), depth_m, picture);
    });
}

}  // namespace equistream
