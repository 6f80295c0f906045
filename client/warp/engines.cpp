#include "engine.h"
#include "resample.h"

#include <equistream/bound.h>

#include <algorithm>
#include <cassert>

namespace equistream {

namespace {

void copy(const SourceView& source, EyePicture& picture) {
    for (int y = 0; y < picture.rgba.height(); ++y)
        for (int x = 0; x < picture.rgba.width(); ++x) {
            if (source.rgb.data != nullptr)
                std::copy_n(source.rgb.pixel(x, y), 3, picture.rgba.pixel(x, y));
            else
                std::ranges::copy(yuv_to_rgb::rgb_at(source.yuv, x, y), picture.rgba.pixel(x, y));
            picture.rgba.pixel(x, y)[3] = 255;
        }
    std::ranges::fill(picture.origin.samples(), std::uint8_t(PixelOrigin::source));
}

class ResampleEngine : public Engine {
public:
    ResampleEngine(bool by_depth, const EngineOptions& options) : by_depth_(by_depth), options_(options) {}

    std::string_view name() const override { return by_depth_ ? "eye-depth" : "rotation"; }
    DepthNeeds needs_depth(const Pose& source, const Pose& eye) const override {
        const bool moved = by_depth_ && !same_position(source, eye);
        return {.source = moved, .eye = moved};
    }
    void set_source(const SourceView& source) override { source_ = source; }
    void reproject(const EyeView& eye, EyePicture& picture) const override {
        assert(source_.rgb.data != nullptr || !source_.yuv.empty());
        picture.size_for(eye.camera);
        ResampleOptions options;
        options.tolerance_rad = error_budget_rad(eye.camera.focal_px(), options_.error_budget_px);
        if (same_camera(source_.camera, eye.camera) && same_pose(source_.pose, eye.pose))
            copy(source_, picture);
        else if (needs_depth(source_.pose, eye.pose).any())
            resample_by_surface(source_, eye, options, picture);
        else
            resample_by_direction(source_, eye, options, picture);
    }

private:
    bool by_depth_;
    EngineOptions options_;
    SourceView source_;
};

}  // namespace

void EyePicture::size_for(const PerspectiveCamera& camera) {
    if (origin.width() != camera.width || origin.height() != camera.height) {
        rgba = ByteImage(camera.width, camera.height, 4);
        origin = ByteImage(camera.width, camera.height, 1);
    }
    reliability = {};
    depth_m = {};
}

void EyePicture::reset(const PerspectiveCamera& camera) {
    size_for(camera);
    std::ranges::fill(rgba.samples(), std::uint8_t{0});
    std::ranges::fill(origin.samples(), std::uint8_t(PixelOrigin::gap));
}

ByteImage EyePicture::rgb() const {
    ByteImage rgb(rgba.width(), rgba.height(), 3);
    for (int y = 0; y < rgba.height(); ++y)
        for (int x = 0; x < rgba.width(); ++x)
            std::copy_n(rgba.pixel(x, y), 3, rgb.pixel(x, y));
    return rgb;
}

std::int64_t EyePicture::count(PixelOrigin which) const {
    return std::ranges::count(origin.samples(), std::uint8_t(which));
}

std::unique_ptr<Engine> make_resample_engine(std::string_view name, const EngineOptions& options) {
    const bool by_depth = name == "eye-depth";
    assert(by_depth || name == "rotation");
    return std::make_unique<ResampleEngine>(by_depth, options);
}

bool same_position(const Pose& a, const Pose& b) {
    return glm::length(a.position_m - b.position_m) < 1e-9;
}

bool same_pose(const Pose& a, const Pose& b) {
    // Of lengths as readers accept them, which are 1 within a thousandth.
    const double dot = glm::dot(a.orientation, b.orientation);
    const double lengths = glm::dot(a.orientation, a.orientation) * glm::dot(b.orientation, b.orientation);
    return same_position(a, b) && dot * dot > (1 - 2e-15) * lengths;
}

bool same_camera(const Camera& a, const Camera& b) {
    if (a.index() != b.index() || width_of(a) != width_of(b) || height_of(a) != height_of(b))
        return false;
    if (const auto* p = std::get_if<PerspectiveCamera>(&a))
        return std::abs(p->fov_x_rad - std::get<PerspectiveCamera>(b).fov_x_rad) < 1e-12;
    const LongitudeLatitudeRange& r = std::get<EquirectCamera>(a).range;
    const LongitudeLatitudeRange& s = std::get<EquirectCamera>(b).range;
    return std::get<EquirectCamera>(a).ods_side_m == std::get<EquirectCamera>(b).ods_side_m &&
           std::abs(r.longitude_min - s.longitude_min) < 1e-12 && std::abs(r.longitude_max - s.longitude_max) < 1e-12 &&
           std::abs(r.latitude_min - s.latitude_min) < 1e-12 && std::abs(r.latitude_max - s.latitude_max) < 1e-12;
}

}  // namespace equistream
