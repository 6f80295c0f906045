#include "source_depth_engine.h"

#include "eye_rays.h"
#include "resample.h"

#include <equistream/bound.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace equistream {

namespace {

class SourceDepthEngine : public Engine {
public:
    SourceDepthEngine(std::string_view name, const EngineOptions& options) : name_(name), options_(options) {}

    std::string_view name() const override { return name_; }
    DepthNeeds needs_depth(const Pose& source, const Pose& eye) const override {
        return {.source = !is_proxy() && !same_position(source, eye)};
    }
    void set_source(const SourceView& source) override {
        source_ = source;
        lattice_.reset();
        if (is_proxy())
            proxy_radius_m_ = proxy_radius_m(source, options_);
        else if (source.depth_m.data != nullptr)
            lattice_.emplace(source.camera, source.depth_m);
    }
    void reproject(const EyeView& eye, EyePicture& picture) const override {
        FloatImage depth_m = std::exchange(picture.depth_m, {});
        picture.size_for(eye.camera);
        if (same_position(source_.pose, eye.pose)) {
            turn(eye, picture);
            return;
        }
        const double tolerance_rad = error_budget_rad(eye.camera.focal_px(), options_.budget_px_of(name_));
        if (depth_m.width() != eye.camera.width || depth_m.height() != eye.camera.height)
            depth_m = FloatImage(eye.camera.width, eye.camera.height, 1);
        tbb::parallel_for(0, eye.camera.height,
                          [&](int y) { std::fill_n(depth_m.pixel(0, y), eye.camera.width, nothing_found); });
        if (is_proxy())
            find_on_proxy_sphere(source_, eye, proxy_radius_m_, depth_m);
        else
            find(eye, tolerance_rad, depth_m);
        to_radial(eye.camera, depth_m);
        const bool only_seen = !is_proxy() && name_ != "mesh-plain";
        resample_by_surface(source_, {eye.camera, eye.pose, depth_m.view()},
                            {.tolerance_rad = tolerance_rad, .only_seen = only_seen}, picture);
        if (is_proxy())
            return;
        picture.depth_m = std::move(depth_m);
        forget_gaps(picture);
    }

private:
    bool is_proxy() const { return name_ == "proxy-sphere"; }

    /// From the source's own position every distance looks the same.
    void turn(const EyeView& eye, EyePicture& picture) const {
        const auto turned = make_engine("rotation", options_);
        turned->set_source(source_);
        turned->reproject(eye, picture);
    }

    void find(const EyeView& eye, double tolerance_rad, FloatImage& inverse_planar) const {
        assert(lattice_);
        const double box_radius_m =
            std::max(source_.box_radius_m, glm::distance(source_.pose.position_m, eye.pose.position_m));
        const FindingTask task{source_,
                               *lattice_,
                               eye,
                               {float(box_radius_m), float(std::sin(tolerance_rad))},
                               float(std::sin(options_.mesh_share * tolerance_rad))};
        if (name_ == "splat")
            find_by_splats(task, inverse_planar);
        else
            find_by_mesh(task, name_ == "mesh-plain", inverse_planar);
    }

    static void to_radial(const PerspectiveCamera& camera, FloatImage& plane) {
        const float step = float(1 / camera.focal_px());
        tbb::parallel_for(0, plane.height(), [&](int y) {
            float* row = plane.pixel(0, y);
            const float b = (float(y) + 0.5f - 0.5f * float(camera.height)) * step;
            for (int x = 0; x < plane.width(); ++x) {
                const float a = (float(x) + 0.5f - 0.5f * float(camera.width)) * step;
                const float inverse = std::max(row[x], 1 / far_distance_m);
                const float radial = std::sqrt(1 + a * a + b * b) / inverse;
                row[x] = row[x] < 0                     ? std::numeric_limits<float>::quiet_NaN()
                         : row[x] <= 1 / far_distance_m ? std::numeric_limits<float>::infinity()
                                                        : radial;
            }
        });
    }

    static void forget_gaps(EyePicture& picture) {
        tbb::parallel_for(0, picture.depth_m.height(), [&](int y) {
            const std::uint8_t* origin = picture.origin.pixel(0, y);
            float* depth_m = picture.depth_m.pixel(0, y);
            for (int x = 0; x < picture.depth_m.width(); ++x)
                if (origin[x] == std::uint8_t(PixelOrigin::gap))
                    depth_m[x] = std::numeric_limits<float>::quiet_NaN();
        });
    }

    std::string name_;
    EngineOptions options_;
    SourceView source_;
    std::optional<SourceLattice> lattice_;
    double proxy_radius_m_ = 0;
};

}  // namespace

std::unique_ptr<Engine> make_source_depth_engine(std::string_view name, const EngineOptions& options) {
    return std::make_unique<SourceDepthEngine>(name, options);
}

double proxy_radius_m(const SourceView& source, const EngineOptions& options) {
    constexpr double without_depth_m = 3;
    if (options.proxy_radius_m > 0)
        return options.proxy_radius_m;
    if (source.depth_m.data == nullptr)
        return without_depth_m;
    std::vector<double> inverse_m;
    constexpr int rows = 64;
    for (int j = 0; j < rows; ++j) {
        const int y = int((j + 0.5) * source.depth_m.height / rows);
        // Rows near a sphere's poles hold fewer directions.
        const auto* sphere = std::get_if<EquirectCamera>(&source.camera);
        const double latitude =
            sphere ? sphere->range.latitude_max - (y + 0.5) * sphere->range.latitude_span() / sphere->height : 0;
        const int columns = std::max(1, int(2 * rows * std::cos(latitude)));
        for (int i = 0; i < columns; ++i)
            if (const double r = source.depth_m.pixel(int((i + 0.5) * source.depth_m.width / columns), y)[0]; r > 0)
                inverse_m.push_back(1 / r);
    }
    if (inverse_m.empty())
        return without_depth_m;
    const auto middle = inverse_m.begin() + std::ptrdiff_t(inverse_m.size() / 2);
    std::nth_element(inverse_m.begin(), middle, inverse_m.end());
    return *middle > 0 ? 1 / *middle : without_depth_m;
}

void find_on_proxy_sphere(const SourceView& source, const EyeView& eye, double radius_m, FloatImage& inverse_planar) {
    const EyeRays rays(eye.camera, eye.pose, source.pose);
    const glm::vec3 from = rays.eye();
    const float beyond = float(radius_m * radius_m) - dot(from, from);
    tbb::parallel_for(0, inverse_planar.height(), [&](int y) {
        float* row = inverse_planar.pixel(0, y);
        for (int x = 0; x < inverse_planar.width(); ++x) {
            const glm::vec3 ray = rays.direction(x, y);
            const float along = dot(ray, from), square = dot(ray, ray);
            const float planar_m = (std::sqrt(along * along + square * beyond) - along) / square;
            row[x] = planar_m > 0 ? 1 / planar_m : nothing_found;
        }
    });
}

}  // namespace equistream
