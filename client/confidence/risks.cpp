#include "risks.h"

#include <client/warp/plane_size.h>

#include <client/warp/engine.h>
#include <equistream/bound.h>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

constexpr float max_radii_outside = 2;
constexpr int longest_step = 8;

/// Rows of a sphere per radian; a flat view's at its middle, where they are fewest.
double density_per_rad(const Camera& camera) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera))
        return sphere->height / sphere->range.latitude_span();
    return std::get<PerspectiveCamera>(camera).focal_px();
}

ImageView<const float> depth_of(const EyeView& eye, const EyePicture& picture) {
    if (eye.depth_m.data != nullptr)
        return eye.depth_m;
    return picture.depth_m.empty() ? ImageView<const float>{} : picture.depth_m.view();
}

/// Mask and depth are gathered from by index, which nothing else would stop at their ends.
void require_sizes(const SourceView& source, const EyeView& eye, const EyePicture& picture) {
    const int width = eye.camera.width, height = eye.camera.height;
    require_plane_size("reliability: colours", picture.rgba.view(), {width, height, 4});
    require_plane_size("reliability: origins", picture.origin.view(), {width, height, 1});
    if (const ImageView<const float> depth_m = depth_of(eye, picture); depth_m.data != nullptr)
        require_plane_size("reliability: depth of the eye", depth_m, {width, height, 1});
    if (source.specular.data != nullptr)
        require_plane_size("reliability: specular mask", source.specular,
                           {width_of(source.camera), height_of(source.camera), 1});
}

}  // namespace

RiskNumbers::RiskNumbers(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                         const ReliabilityOptions& options)
    : RiskNumbers(source, eye, depth_of(eye, picture).data != nullptr, options) {
    depth_m = depth_of(eye, picture);
    require_sizes(source, eye, picture);
}

RiskNumbers::RiskNumbers(const SourceView& source, const EyeView& eye, bool has_depth,
                         const ReliabilityOptions& options) {
    const glm::dvec3 centre_world = source.pose.position_m - eye.pose.position_m;
    const glm::dvec3 in_eye = glm::conjugate(eye.pose.orientation) * centre_world;
    const double focal = eye.camera.focal_px();
    centre = {float(in_eye.x), float(in_eye.y), float(in_eye.z)};
    baseline_m = float(glm::length(centre_world));
    focal_px = float(focal);
    density = float(density_per_rad(source.camera) / focal);
    step = std::clamp(int(std::lround(1 / density)), 1, longest_step);
    texture_reach = texture_steps * step;
    const double box = source.box_radius_m > 0 ? source.box_radius_m : baseline_m;
    if (box > 0) {
        const double share = baseline_m / box;
        outside = float(std::clamp(share - 1 - 1e-6, 0.0, double(max_radii_outside)));
        depth_error_px = float(options.depth_tolerance_w * share * focal);
    }
    // Far outside the box w is B / r, so a step of w is B times one of 1 / r.
    min_step_inverse_m = float(error_budget_rad(focal) / std::max<double>(baseline_m, 1e-6));
    if (std::holds_alternative<EquirectCamera>(source.camera)) {
        const glm::dvec3 up = glm::conjugate(eye.pose.orientation) * (source.pose.orientation * glm::dvec3(0, 1, 0));
        pole = {float(up.x), float(up.y), float(up.z)};
    }
    const bool moved = !same_position(source.pose, eye.pose);
    if (moved && !has_depth)
        known = KnownDepth::none;
    else if (depth_error_px > default_budget_share * error_budget_rad(focal) * focal)
        known = KnownDepth::coarse;
    coding_loss = options.coding_loss.value_or(CodingLoss{});
    mirrors = source.specular.data != nullptr && !options.specular_reworked && has_depth && moved;
}

bool same_view(const SourceView& source, const EyeView& eye) {
    return same_camera(source.camera, eye.camera) && same_pose(source.pose, eye.pose);
}

}  // namespace equistream
