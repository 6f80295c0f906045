#include <equistream_client/specular.h>

#include "eye_rays.h"
#include "image_look_up.h"

#include <equistream/bound.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <mutex>

namespace equistream {

namespace {

/// Sine of 1 degree. Where no image is found, a colour displaced by less is mostly nearer the truth than what would
/// fill the gap, one displaced by more is not: tried from 0 to 90 degrees on curved and flat mirrors, at 63 mm and 0.25
/// m.
constexpr float most_displacement = 0.01745f;

template <typename Lookup>
class SpecularRework {
public:
    SpecularRework(const Lookup& lookup, const SourceView& source, const EyeView& eye, double budget_rad)
        : lookup_(lookup), source_(source),
          rays_(eye.camera, eye.pose, source.pose), agreement_{std::max(float(source.box_radius_m), rays_.distance_m()),
                                                               float(std::sin(budget_rad))},
          images_(lookup, source, rays_.eye(), agreement_) {}

    enum class Answer { untouched, kept, by_image, displaced, gap };

    /// `depth_m`: of what the eye's pixel shows.
    Answer rework(int x, int y, float depth_m, std::uint8_t* rgba) const {
        if (!(depth_m > 0))
            return Answer::untouched;
        const Vec3f ray = rays_.direction(x, y) * (1 / rays_.length(x, y));
        const float surface_m = std::min(depth_m, far_distance_m);
        const Vec3f towards = rays_.eye() * (1 / surface_m) + ray;
        const SpecularSample surface = images_.sample(lookup_.project(towards));
        if (!surface.specular)
            return Answer::untouched;
        const float image_m = image_distance(source_, surface);
        if (warps_with_surface(agreement_, source_.depth_m.pixel(surface.x, surface.y)[0], image_m))
            return Answer::kept;
        if (std::isnan(image_m))
            return Answer::gap;
        const auto found = images_.first_beyond(ray, surface_m);
        if (!found)
            return images_.displacement(ray, towards, image_m) <= most_displacement ? Answer::displaced : Answer::gap;
        const Vec3f colour = images_.colour(*found);
        rgba[0] = std::uint8_t(colour.x + 0.5f);
        rgba[1] = std::uint8_t(colour.y + 0.5f);
        rgba[2] = std::uint8_t(colour.z + 0.5f);
        return Answer::by_image;
    }

private:
    const Lookup& lookup_;
    const SourceView& source_;
    EyeRays rays_;
    DepthAgreement agreement_;
    ImageLookUp<Lookup> images_;
};

template <typename Lookup>
SpecularCounts rework_all(const SpecularRework<Lookup>& rework, ImageView<const float> depth_m, EyePicture& picture) {
    using Answer = typename SpecularRework<Lookup>::Answer;
    SpecularCounts total;
    std::mutex mutex;
    tbb::parallel_for(tbb::blocked_range<int>(0, depth_m.height, 8), [&](const tbb::blocked_range<int>& rows) {
        SpecularCounts counts;
        for (int y = rows.begin(); y < rows.end(); ++y)
            for (int x = 0; x < depth_m.width; ++x) {
                std::uint8_t* origin = picture.origin.pixel(x, y);
                if (*origin != std::uint8_t(PixelOrigin::source))
                    continue;
                const Answer answer = rework.rework(x, y, *depth_m.pixel(x, y), picture.rgba.pixel(x, y));
                counts.kept += answer == Answer::kept;
                counts.by_image += answer == Answer::by_image;
                counts.displaced += answer == Answer::displaced;
                if (answer != Answer::gap)
                    continue;
                ++counts.gaps;
                *origin = std::uint8_t(PixelOrigin::gap);
                std::fill_n(picture.rgba.pixel(x, y), 4, std::uint8_t{0});
                if (!picture.depth_m.empty())
                    *picture.depth_m.pixel(x, y) = std::nanf("");
            }
        const std::scoped_lock lock(mutex);
        total += counts;
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
    const auto run = [&](const auto& lookup) {
        return rework_all(SpecularRework(lookup, source, eye, budget_rad), depth_m, picture);
    };
    if (const auto* sphere = std::get_if<EquirectCamera>(&source.camera))
        return run(EquirectLookup(*sphere));
    return run(PerspectiveLookup(std::get<PerspectiveCamera>(source.camera)));
}

}  // namespace equistream
