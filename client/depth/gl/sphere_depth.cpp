#include "sphere_depth.h"

#include <equistream/text.h>

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <vector>

namespace equistream::gl {

namespace {

/// Of half a flat view: beyond, its corners are many times denser than its middle.
constexpr double widest_half_rad = 62 * pi / 180;
/// Around what is looked up, in samples: sixteen taps, the farthest 2 columns and 2 rows away.
constexpr double spare_samples = 3;
/// Points on each side of an eye's picture whose rays are followed.
constexpr int border_steps = 32;

/// Pixels per radian of the source.
double density_px(const EquirectCamera& camera) {
    return std::max(camera.width / camera.range.longitude_span(), camera.height / camera.range.latitude_span());
}

PerspectiveCamera flat_camera(double half_x_rad, double half_y_rad, double focal_px) {
    // One more, so that no sample falls between two faces.
    const auto side = [focal_px](double half_rad) { return int(std::ceil(2 * focal_px * std::tan(half_rad))) + 1; };
    const int width = side(half_x_rad);
    return {width, side(half_y_rad), 2 * std::atan(width / (2 * focal_px))};
}

/// Angle of the taps around what is looked up.
double spare_rad(const EquirectCamera& camera) {
    return spare_samples *
           std::max(camera.range.longitude_span() / camera.width, camera.range.latitude_span() / camera.height);
}

/// Turns -Z to the middle of where all eyes look, and keeps their up.
glm::dquat gaze_of(std::span<const EyeView> eyes) {
    const glm::dquat& first = eyes.front().pose.orientation;
    glm::dquat sum = first;
    for (const EyeView& eye : eyes.subspan(1)) {
        const double sign = glm::dot(sum, eye.pose.orientation) < 0 ? -1 : 1;
        sum += sign * eye.pose.orientation;
    }
    return glm::length(sum) > 1e-3 ? glm::normalize(sum) : first;
}

/// How far from the gaze something may be looked up: towards the sides, up and down, and at all.
struct Reach {
    double x_rad = 0, y_rad = 0, any_rad = 0;

    void include(const Reach& other) {
        x_rad = std::max(x_rad, other.x_rad);
        y_rad = std::max(y_rad, other.y_rad);
        any_rad = std::max(any_rad, other.any_rad);
    }
};

/// Of all directions within an angle of `d`: the largest angle about an axis across the gaze, of which `aside` is d's
/// part; at the poles of that axis a small step goes all the way round.
double angle_about(double aside, double forward, double tilt_rad) {
    const double from_axis = std::hypot(aside, forward);
    if (tilt_rad >= pi / 2 || std::sin(tilt_rad) >= from_axis)
        return pi;
    return std::abs(std::atan2(aside, forward)) + std::asin(std::sin(tilt_rad) / from_axis);
}

/// What a ray of the eye's shows lies between its own direction, far away, and where it is nearest_shown_m from the
/// source: as seen from there its angles about any axis grow or shrink all the way.
Reach reach_of(const EyeView& eye, const Pose& source, const glm::dquat& gaze, double spare) {
    const glm::dvec3 offset = glm::conjugate(gaze) * (eye.pose.position_m - source.position_m);
    if (glm::length(offset) >= nearest_shown_m)
        return {pi, pi, pi};
    Reach reach;
    const auto include = [&](const glm::dvec3& d) {
        reach.include({angle_about(d.x, -d.z, spare), angle_about(d.y, -d.z, spare),
                       std::acos(std::clamp(-d.z, -1.0, 1.0)) + spare});
    };
    const auto follow = [&](double u, double v) {
        const glm::dvec3 d = glm::conjugate(gaze) *
                             (eye.pose.orientation * eye.camera.direction(u * eye.camera.width, v * eye.camera.height));
        const double along = glm::dot(d, offset);
        const double nearest_m =
            std::sqrt(along * along + nearest_shown_m * nearest_shown_m - glm::dot(offset, offset));
        include(d);
        include((offset + (nearest_m - along) * d) / nearest_shown_m);
    };
    for (int step = 0; step <= border_steps; ++step) {
        const double along = double(step) / border_steps;
        for (const double side : {0.0, 1.0}) {
            follow(along, side);
            follow(side, along);
        }
    }
    return reach;
}

SampleRange all_samples(const EquirectCamera& camera) {
    return {0, 0, camera.width, camera.height};
}

/// Where a view's border lies on the sphere: an area without a pole has its extremes there.
struct Outline {
    double min_latitude = pi / 2, max_latitude = -pi / 2, longitude_aside = 0;

    void include(double latitude, double aside) {
        min_latitude = std::min(min_latitude, latitude);
        max_latitude = std::max(max_latitude, latitude);
        longitude_aside = std::max(longitude_aside, std::abs(aside));
    }
};

/// Samples whose directions lie in a flat view at the source's place, and a few around them.
SampleRange samples_in(const DepthViewpoint& view, const EquirectCamera& camera, const Pose& source) {
    const glm::dquat source_from_view = glm::conjugate(source.orientation) * view.pose.orientation;
    const glm::dvec3 towards = source_from_view * glm::dvec3(0, 0, -1);
    const double middle = std::atan2(towards.x, -towards.z);
    Outline outline;
    for (int step = 0; step < border_steps; ++step)
        for (int side = 0; side < 4; ++side) {
            const double along = double(step) / border_steps;
            const double u = side < 2 ? along : side - 2, v = side < 2 ? side : along;
            const glm::dvec3 d =
                source_from_view * view.camera.direction(u * view.camera.width, v * view.camera.height);
            outline.include(std::asin(std::clamp(d.y, -1.0, 1.0)),
                            std::remainder(std::atan2(d.x, -d.z) - middle, 2 * pi));
        }
    bool has_pole = false;
    for (const double pole : {1.0, -1.0}) {
        const glm::dvec3 at = glm::conjugate(source_from_view) * glm::dvec3(0, pole, 0);
        const double focal = view.camera.focal_px();
        if (!(at.z < 0 && std::abs(at.x / at.z) * focal <= 0.5 * view.camera.width &&
              std::abs(at.y / at.z) * focal <= 0.5 * view.camera.height))
            continue;
        has_pole = true;
        outline.include(pole * pi / 2, pi);
    }
    // Between two points of the border it bulges by less than a step's width.
    const double spare = spare_rad(camera) + 0.01;
    const double rows_per_radian = camera.height / camera.range.latitude_span();
    const double columns_per_radian = camera.width / camera.range.longitude_span();
    SampleRange range = all_samples(camera);
    const auto row_of = [&](double latitude) { return (camera.range.latitude_max - latitude) * rows_per_radian; };
    range.first_row = std::clamp(int(std::floor(row_of(outline.max_latitude + spare))), 0, camera.height);
    range.rows = std::clamp(int(std::ceil(row_of(outline.min_latitude - spare))), range.first_row, camera.height) -
                 range.first_row;
    const double steepest = std::max(std::abs(outline.min_latitude), std::abs(outline.max_latitude)) + spare;
    if (has_pole || steepest >= pi / 2 || !camera.range.closes())
        return range;
    const double aside = outline.longitude_aside + spare / std::cos(steepest);
    const int columns = 2 * int(std::ceil(aside * columns_per_radian)) + 2;
    if (columns >= camera.width)
        return range;
    range.columns = columns;
    range.first_column = (int(std::floor(camera.pixel(towards).x)) - columns / 2 + camera.width) % camera.width;
    return range;
}

/// Faces of a cube that looks along the gaze, as far as something in them may be looked up.
void add_faces(const glm::dquat& gaze, const Pose& source, double focal_px, const Reach& reach, SphereViews& all) {
    const PerspectiveCamera camera = flat_camera(pi / 4, pi / 4, focal_px);
    const glm::dvec3 x(1, 0, 0), y(0, 1, 0);
    const auto add = [&](double turn, const glm::dvec3& axis) {
        all.views.push_back({camera, {source.position_m, gaze * glm::angleAxis(turn, axis)}});
    };
    add(0, y);
    const bool sideways = reach.any_rad >= pi / 2;
    for (const double turn : {pi / 2, -pi / 2}) {
        if (sideways || reach.x_rad > pi / 4)
            add(turn, y);
        if (sideways || reach.y_rad > pi / 4)
            add(turn, x);
    }
    if (reach.any_rad > 3 * pi / 4)
        add(pi, y);
}

}  // namespace

SphereViews sphere_views(const EquirectCamera& camera, const Pose& pose, std::span<const EyeView> eyes) {
    const glm::dquat gaze = gaze_of(eyes);
    Reach reach;
    for (const EyeView& eye : eyes)
        reach.include(reach_of(eye, pose, gaze, spare_rad(camera)));
    const double focal_px = density_px(camera);
    SphereViews all;
    if (std::max(reach.x_rad, reach.y_rad) <= widest_half_rad) {
        all.views.push_back({flat_camera(reach.x_rad, reach.y_rad, focal_px), {pose.position_m, gaze}});
        all.samples = samples_in(all.views.front(), camera, pose);
        return all;
    }
    add_faces(gaze, pose, focal_px, reach, all);
    all.samples = all_samples(camera);
    return all;
}

SphereViews cube_views(const EquirectCamera& camera, const Pose& pose) {
    SphereViews all;
    add_faces(pose.orientation, pose, density_px(camera), {pi, pi, pi}, all);
    all.samples = all_samples(camera);
    return all;
}

SphereViews flat_source_views(const PerspectiveCamera& camera, const Pose& pose) {
    SphereViews all;
    all.views.push_back({camera, pose});
    all.samples = {0, 0, camera.width, camera.height};
    return all;
}

namespace {

/// As std140 has it.
struct FlatView {
    glm::mat4 view_from_source;
    glm::vec4 size;
};

/// In barycentric coordinates, so that no ray slips through between two triangles.
constexpr double edge_tolerance = 1e-5;

std::vector<std::string> defines(std::size_t views) {
    std::vector<std::string> all = DepthPass::geometry_defines();
    all.push_back(formatted("EDGE %.9g", edge_tolerance));
    all.push_back("VIEWS " + std::to_string(views));
    return all;
}

}  // namespace

SphereDepth::Passes::Passes(std::size_t views)
    : first("sphere_depth_first.glsl", defines(views)), listed("sphere_depth.glsl", defines(views)) {}

SphereDepth::SphereDepth(double box_radius_m, double error_rad)
    : box_radius_m_(float(box_radius_m)), error_(float(std::sin(error_rad))), one_view_(1),
      faces_(SourceViewpoints::most),
      views_(make_buffer(SourceViewpoints::most * sizeof(FlatView), GL_DYNAMIC_STORAGE_BIT)) {}

void SphereDepth::resolve(const DepthPass& pass, int first_layer, const SphereViews& views, const Pose& source_pose,
                          SourceTextures& source) {
    assert(views.views.size() > 0);
    std::array<FlatView, SourceViewpoints::most> blocks{};  // no sample lies in those that are not there
    for (std::size_t i = 0; i < views.views.size(); ++i) {
        const DepthViewpoint& view = views.views[i];
        const glm::dquat turn = glm::conjugate(view.pose.orientation) * source_pose.orientation;
        blocks[i] = {glm::mat4(glm::mat4_cast(turn)),
                     {view.camera.width, view.camera.height, view.camera.focal_px(), first_layer + int(i)}};
    }
    glNamedBufferSubData(views_.name(), 0, sizeof blocks, blocks.data());
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, views_.name());
    pass.geometry().bind();
    glBindTextureUnit(0, pass.texture());
    glBindTextureUnit(1, pass.triangles());
    glBindImageTexture(0, source.depth_to_write(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    const Passes& passes = views.views.size() == 1 ? one_view_ : faces_;
    for (const Program* program : {&passes.first, &passes.listed})
        program->set("inverse_depth_scale", DepthPass::inverse_scale());
    passes.first.set("box_radius_m", box_radius_m_);
    passes.first.set("error", error_);
    passes.first.set("first", glm::ivec2(views.samples.first_column, views.samples.first_row));
    passes.first.set("wanted", glm::ivec2(views.samples.columns, views.samples.rows));
    passes.listed.set("centre_world", glm::vec3(source_pose.position_m));
    passes.listed.set("world_from_source", glm::mat3(glm::mat3_cast(source_pose.orientation)));
    list_.size_for(std::size_t(source.size().width) * std::size_t(source.size().height));
    list_.start();
    passes.first.dispatch({views.samples.columns, views.samples.rows});
    list_.dispatch(passes.listed);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

}  // namespace equistream::gl
