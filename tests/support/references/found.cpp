#include "plain_engines.h"
#include "plain_task.h"

#include <client/stages/stages.h>
#include <client/warp/source_depth_engine.h>
#include <equistream/bound.h>

#include <cassert>
#include <cmath>
#include <limits>
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
    FoundEngine(std::string_view name, const EngineOptions& options) : name_(name), options_(options) {}

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
            find_by_lean(task, inverse_planar);
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

}  // namespace equistream::plain
