#include "plain_engines.h"
#include "plain_surface.h"

#include <equistream/bound.h>

#include <client/stages/stages.h>
#include <client/warp/source_depth_engine.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

namespace equistream::plain {

namespace {

/// The bilinear colour in a direction of the source's frame; false where the source does not cover it.
bool colour_of(const SourceView& source, const glm::dvec3& direction, std::uint8_t* rgba) {
    const int width = width_of(source.camera), height = height_of(source.camera);
    const glm::dvec2 p = pixel_of(source.camera, direction);
    if (!(p.x >= 0 && p.y >= 0 && p.x <= width && p.y <= height))
        return false;
    const auto* sphere = std::get_if<EquirectCamera>(&source.camera);
    const bool closes = sphere && sphere->range.closes(), full = sphere && sphere->range.is_full_sphere();
    const glm::dvec2 corner = glm::floor(p - 0.5), a = p - 0.5 - corner;
    glm::dvec3 sum(0);
    for (int k = 0; k < 4; ++k) {
        int x = int(corner.x) + k % 2, y = int(corner.y) + k / 2;
        if (full && (y < 0 || y >= height))
            x += width / 2;
        x = closes ? (x % width + width) % width : std::clamp(x, 0, width - 1);
        const glm::dvec3 sample = colour_of_sample(source, x, std::clamp(y, 0, height - 1));
        sum += (k % 2 ? a.x : 1 - a.x) * (k / 2 ? a.y : 1 - a.y) * sample;
    }
    for (int c = 0; c < 3; ++c)
        rgba[c] = std::uint8_t(sum[c] + 0.5);
    rgba[3] = 255;
    return true;
}

class FoundEngine : public Engine {
public:
    FoundEngine(std::string_view name, const EngineOptions& options) : name_(name), options_(options) {
        options_.error_budget_px = options.budget_px_of(name);
    }

    std::string_view name() const override { return name_; }
    DepthNeeds needs_depth(const Pose& source, const Pose& eye) const override {
        return {.source = name_ != "proxy-sphere" && !same_position(source, eye)};
    }
    void set_source(const SourceView& source) override { source_ = source; }

    void reproject(const EyeView& eye, EyePicture& picture) const override {
        if (same_position(source_.pose, eye.pose)) {
            const auto turned = make_resample_engine(false, options_);
            turned->set_source(source_);
            turned->reproject(eye, picture);
            return;
        }
        const FloatImage depth_m = found(eye);
        if (name_ == "proxy-sphere" || name_ == "mesh-plain") {
            colour_everything(eye, depth_m, picture);
        } else {
            const auto by_depth = make_resample_engine(true, options_);
            by_depth->set_source(source_);
            by_depth->reproject({eye.camera, eye.pose, depth_m.view()}, picture);
        }
        if (name_ == "proxy-sphere")
            return;
        picture.depth_m = depth_m;
        for (int y = 0; y < eye.camera.height; ++y)
            for (int x = 0; x < eye.camera.width; ++x)
                if (*picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap))
                    *picture.depth_m.pixel(x, y) = std::nanf("");
    }

private:
    FloatImage found(const EyeView& eye) const {
        Image<double> inverse_planar(eye.camera.width, eye.camera.height, 1, -1);
        const PlainTask task{source_, eye, options_};
        if (name_ == "splat")
            find_by_splat(task, inverse_planar);
        else if (name_ == "proxy-sphere")
            find_on_proxy_sphere(task, inverse_planar);
        else
            find_by_mesh(task, name_ == "mesh-plain", inverse_planar);
        FloatImage depth_m(eye.camera.width, eye.camera.height, 1);
        for (int y = 0; y < eye.camera.height; ++y)
            for (int x = 0; x < eye.camera.width; ++x) {
                const double s = *inverse_planar.pixel(x, y);
                const double radial_m = 1 / (s * -eye.camera.direction(x + 0.5, y + 0.5).z);
                *depth_m.pixel(x, y) = s < 0      ? std::nanf("")
                                       : s > 1e-9 ? float(radial_m)
                                                  : std::numeric_limits<float>::infinity();
            }
        return depth_m;
    }

    void colour_everything(const EyeView& eye, const FloatImage& depth_m, EyePicture& picture) const {
        picture.reset(eye.camera);
        for (int y = 0; y < eye.camera.height; ++y)
            for (int x = 0; x < eye.camera.width; ++x) {
                const double distance_m = *depth_m.pixel(x, y);
                if (std::isnan(distance_m))
                    continue;
                const glm::dvec3 ray = eye.pose.orientation * eye.camera.direction(x + 0.5, y + 0.5);
                const glm::dvec3 point =
                    std::isinf(distance_m) ? ray : eye.pose.position_m + distance_m * ray - source_.pose.position_m;
                if (colour_of(source_, glm::conjugate(source_.pose.orientation) * point, picture.rgba.pixel(x, y)))
                    *picture.origin.pixel(x, y) = std::uint8_t(PixelOrigin::source);
            }
    }

    std::string name_;
    EngineOptions options_;
    SourceView source_;
};

}  // namespace

double PlainTask::box_radius_m() const {
    return std::max(source.box_radius_m, glm::length(eye_from_source_m()));
}

double PlainTask::tolerance_rad() const {
    return error_budget_rad(eye.camera.focal_px(), options.error_budget_px);
}

std::unique_ptr<Engine> make_engine(std::string_view name, const EngineOptions& options) {
    const std::string_view of_today = find_engine(name).name;
    if (of_today == "rotation" || of_today == "eye-depth")
        return make_resample_engine(of_today == "eye-depth", options);
    return std::make_unique<FoundEngine>(of_today, options);
}

/// Where each ray of the eye leaves the sphere of pictures.
void find_on_proxy_sphere(const PlainTask& task, Image<double>& inverse_planar) {
    const double radius_m = proxy_radius_m(task.source, task.options);
    const glm::dvec3 from = task.eye_from_source_m();
    for (int y = 0; y < inverse_planar.height(); ++y)
        for (int x = 0; x < inverse_planar.width(); ++x) {
            const glm::dvec3 own = task.eye.camera.direction(x + 0.5, y + 0.5);
            const glm::dvec3 ray = task.eye.pose.orientation * own;
            const double along = glm::dot(from, ray);
            const double distance_m = -along + std::sqrt(along * along - glm::dot(from, from) + radius_m * radius_m);
            *inverse_planar.pixel(x, y) = distance_m > 0 ? 1 / (distance_m * -own.z) : -1;
        }
}

namespace {

struct Axis {
    glm::dvec2 step;
    double inverse_planar = 0;
    double half = 0.55;  ///< of a step, to either side
};

/// Half of the way from neighbour to neighbour; of one neighbour where there is one; a pixel at equal distance if none.
Axis axis_of(const PlainSurface& surface, int x, int y, int dx, int dy) {
    const PlainEyePoint here = surface.project(surface.point(x, y));
    struct Step {
        glm::dvec2 pixels;
        double inverse_planar;
    };
    std::optional<Step> before, after;
    if (surface.is_sample(x - dx, y - dy) && surface.joined(x - dx, y - dy, dx, dy)) {
        const PlainEyePoint p = surface.project(surface.point(x - dx, y - dy));
        if (!std::isnan(p.inverse_planar))
            before = {here.pixel - p.pixel, here.inverse_planar - p.inverse_planar};
    }
    if (surface.is_sample(x + dx, y + dy) && surface.joined(x, y, dx, dy)) {
        const PlainEyePoint p = surface.project(surface.point(x + dx, y + dy));
        if (!std::isnan(p.inverse_planar))
            after = {p.pixel - here.pixel, p.inverse_planar - here.inverse_planar};
    }
    if (before && after) {
        Axis axis{0.5 * (before->pixels + after->pixels), 0.5 * (before->inverse_planar + after->inverse_planar)};
        const double longest = std::max(glm::length(before->pixels), glm::length(after->pixels));
        axis.half = 0.5 * longest / glm::length(axis.step) + 0.05;
        return axis;
    }
    if (before || after) {
        const Step& one = before ? *before : *after;
        return {one.pixels, one.inverse_planar};
    }
    const PlainEyePoint beside = surface.project({surface.direction(x + dx, y + dy), surface.inverse(x, y)});
    return {beside.pixel - here.pixel, beside.inverse_planar - here.inverse_planar};
}

}  // namespace

/// A buffer of depths decides what is in front, not an order.
void find_by_splat(const PlainTask& task, Image<double>& inverse_planar) {
    const PlainSurface surface(task);
    for (int y = 0; y < surface.height(); ++y)
        for (int x = 0; x < surface.width(); ++x) {
            const PlainEyePoint here = surface.project(surface.point(x, y));
            if (std::isnan(here.inverse_planar))
                continue;
            Axis across = axis_of(surface, x, y, 1, 0);
            const Axis down = axis_of(surface, x, y, 0, 1);
            // A pixel next to a sphere's pole is wider at one edge than in its middle.
            const double width = glm::distance(surface.direction(0, y), surface.direction(1, y));
            const double wider = std::max(glm::distance(surface.direction(0, y - 1), surface.direction(1, y - 1)),
                                          glm::distance(surface.direction(0, y + 1), surface.direction(1, y + 1)));
            across.half *= 0.5 + 0.5 * wider / width;
            const glm::dmat2 steps(across.step, down.step);
            if (!(glm::determinant(steps) > 0))
                continue;
            const glm::dmat2 inverse = glm::inverse(steps);
            const glm::dvec2 half = across.half * glm::abs(across.step) + down.half * glm::abs(down.step);
            if (std::max(half.x, half.y) > 32)
                continue;
            for (int j = std::max(0, int(here.pixel.y - half.y - 1)); j <= int(here.pixel.y + half.y + 1); ++j)
                for (int i = std::max(0, int(here.pixel.x - half.x - 1)); i <= int(here.pixel.x + half.x + 1); ++i) {
                    if (i >= inverse_planar.width() || j >= inverse_planar.height())
                        continue;
                    const glm::dvec2 place = inverse * (glm::dvec2(i + 0.5, j + 0.5) - here.pixel);
                    if (std::abs(place.x) > across.half || std::abs(place.y) > down.half)
                        continue;
                    const double value =
                        here.inverse_planar + place.x * across.inverse_planar + place.y * down.inverse_planar;
                    double& nearest = *inverse_planar.pixel(i, j);
                    nearest = std::max(nearest, std::max(value, 0.0));
                }
        }
}

}  // namespace equistream::plain
