#include "specular.h"
#include "mirror_kernels.h"

#include <client/warp/plane_size.h>
#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <string>

namespace equistream {

namespace {

constexpr std::array<std::string_view, 3> treatment_names = {"images", "gaps", "surface"};

void open_gap(EyePicture& picture, int x, int y) {
    *picture.origin.pixel(x, y) = std::uint8_t(PixelOrigin::gap);
    std::fill_n(picture.rgba.pixel(x, y), 4, std::uint8_t{0});
    if (!picture.depth_m.empty())
        *picture.depth_m.pixel(x, y) = std::nanf("");
}

/// Does with a row's pixels what was found of them.
SpecularCounts apply(const MirrorRow& row, int y, const ImageColour& colour, EyePicture& picture) {
    SpecularCounts counts;
    for (std::size_t i = 0; i < std::size_t(row.count); ++i) {
        const int x = row.x[i];
        switch (MirrorAnswer(row.answer[i])) {
        case MirrorAnswer::kept:
            ++counts.kept;
            break;
        case MirrorAnswer::displaced:
            ++counts.displaced;
            break;
        case MirrorAnswer::by_image: {
            ++counts.by_image;
            const glm::vec3 found = colour.at({row.u[i], row.v[i]});
            std::uint8_t* rgba = picture.rgba.pixel(x, y);
            rgba[0] = std::uint8_t(found.x + 0.5f);
            rgba[1] = std::uint8_t(found.y + 0.5f);
            rgba[2] = std::uint8_t(found.z + 0.5f);
            break;
        }
        case MirrorAnswer::gap:
            ++counts.gaps;
            open_gap(picture, x, y);
        }
    }
    return counts;
}

SpecularCounts rework_all(ImageFinder* find, const MirrorJob& job, EyePicture& picture) {
    const ImageColour colour(job.source, job.agreement);
    SpecularCounts total;
    std::mutex mutex;
    const tbb::blocked_range<int> all_rows(0, job.eye.camera.height, 8);
    tbb::parallel_for(all_rows, [&](const tbb::blocked_range<int>& rows) {
        MirrorRow row(job.eye.camera.width);
        SpecularCounts counts;
        for (int y = rows.begin(); y < rows.end(); ++y) {
            find(job, y, row);
            counts += apply(row, y, colour, picture);
        }
        const std::scoped_lock lock(mutex);
        total += counts;
    });
    return total;
}

}  // namespace

std::span<const std::string_view> mirror_treatment_names() {
    return treatment_names;
}

MirrorTreatment find_mirror_treatment(std::string_view name, std::string_view option) {
    const auto found = std::ranges::find(treatment_names, name);
    if (found == treatment_names.end())
        throw InputError(
            expected_found(std::string(option), in_a_sentence(treatment_names, " or "), "'" + std::string(name) + "'"));
    return MirrorTreatment(found - treatment_names.begin());
}

SpecularCounts rework_specular(const SourceView& source, const EyeView& eye, EyePicture& picture,
                               const SpecularOptions& options) {
    return rework_specular_by(find_images, source, eye, picture, options);
}

SpecularCounts rework_specular_by(ImageFinder* find, const SourceView& source, const EyeView& eye, EyePicture& picture,
                                  const SpecularOptions& options) {
    if (options.treatment == MirrorTreatment::surface)
        return {};
    const bool own = eye.depth_m.data == nullptr && !picture.depth_m.empty();
    const EyeView seen{eye.camera, eye.pose, own ? ImageView<const float>(picture.depth_m.view()) : eye.depth_m};
    if (source.specular.data == nullptr || source.depth_m.data == nullptr || seen.depth_m.data == nullptr)
        return {};
    const PlaneSize of_source{width_of(source.camera), height_of(source.camera), 1};
    require_plane_size("mirrors: mask", source.specular, of_source);
    require_plane_size("mirrors: depth of the source", source.depth_m, of_source);
    if (source.virtual_depth_m.data != nullptr)
        require_plane_size("mirrors: virtual depth", source.virtual_depth_m, of_source);
    require_plane_size("mirrors: depth of the eye", seen.depth_m, {eye.camera.width, eye.camera.height, 1});
    const EyeRays rays(eye.camera, eye.pose, source.pose);
    const double budget_rad = error_budget_rad(eye.camera.focal_px(), options.error_budget_px);
    const MirrorJob job{
        .grid = source_grid(source.camera),
        .source = source,
        .eye = seen,
        .rays = rays,
        .origin = picture.origin.view(),
        .agreement = {std::max(float(source.box_radius_m), rays.distance_m()), float(std::sin(budget_rad))},
        .looks_for_images = options.treatment == MirrorTreatment::images};
    return rework_all(find, job, picture);
}

}  // namespace equistream
