/// The bound measured (DESIGN.md, "one bound"; bound.h): for random eyes in the head box, how far from where it belongs
/// does an engine show what it shows? A pixel that an engine coloured shows the surface that the source's centre sees
/// in some direction q; a ray cast along q says where that surface really is, and the angle at the eye between it and
/// the pixel's own ray is the shift, in pixels of the eye's view at its centre.
///
/// What lies between the source's samples no client can know: a leaf thinner than a pixel, where exactly a silhouette
/// runs. So pixels are told apart by whether the samples around q, linear in w, tell the depth there to within the
/// budget: "sampled" ones, for which the bound must hold, and the others. "Smooth" are pixels around which the samples
/// bend, along each axis, by no more than linear interpolation may be off by: told without the truth, as a client
/// could; none of those samples lies in the box, of which the bound says nothing. What an engine adds to a smooth pixel
/// is its shift beyond what the samples' own error explains. Prints JSON, for each engine: quantiles of the shift and
/// the share within the budget, over all coloured pixels, the smooth and the sampled ones, and of what it added.
#include "random_eyes.h"

#include <client/depth/ray_depth.h>
#include <client/warp/engine.h>
#include <equistream/bound.h>
#include <equistream/error.h>
#include <scenes/embree/embree_rays.h>

#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace equistream {
namespace {

struct Options : RandomEyeOptions {
    Options() { size = "480x270"; }
    std::string model, engines = "eye-depth,mesh,splat";
};

/// Casts along directions that no camera has; the geometry is always the scene's own.
class Truth {
public:
    explicit Truth(const SceneDescription& scene)
        : model_(load_model(scene, {.shading = false})),
          bvh_(model_, {.moving_instances = find_moving_instances(model_, scene)}) {
        if (!scene.moving.empty())
            throw InputError(expected_found(scene.file.string(), "a scene that stands still", "moving objects"));
    }
    double distance_m(const glm::dvec3& from, const glm::dvec3& direction) const {
        RTCRayHit query = embree_ray_hit(glm::vec3(from), glm::vec3(direction));
        bvh_.intersect1(query);
        return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? std::numeric_limits<double>::infinity()
                                                           : double(query.ray.tfar);
    }

private:
    SceneModel model_;
    Bvh bvh_;
};

FloatImage cast(DepthSource& source, const Camera& camera, const Pose& pose) {
    FloatImage depth_m(width_of(camera), height_of(camera), 1);
    source.cast(camera, pose, depth_m.view());
    return depth_m;
}

/// What the source's samples around a direction say of w there: no number where one of them lies in the box.
struct SampledW {
    double interpolated = 0;
    double bend = 0;  ///< the largest second difference of the 4x4 samples around: an eighth of it is what linear
                      ///< interpolation between samples may be off by
};

SampledW sampled_w(const FloatImage& depth_m, const EquirectCamera& camera, glm::dvec2 pixel, double box_radius_m) {
    const glm::dvec2 corner = glm::floor(pixel - 0.5);
    const glm::dvec2 a = pixel - 0.5 - corner;
    double w[4][4];
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
            const int x = (int(corner.x) + i - 1 + camera.width) % camera.width;
            const int y = std::clamp(int(corner.y) + j - 1, 0, camera.height - 1);
            const double distance_m = depth_m.pixel(x, y)[0];
            w[j][i] = distance_m > box_radius_m ? bounded_inverse_depth(distance_m, box_radius_m) : std::nan("");
        }
    SampledW found;
    found.interpolated = glm::mix(glm::mix(w[1][1], w[1][2], a.x), glm::mix(w[2][1], w[2][2], a.x), a.y);
    for (int k = 0; k < 4; ++k)
        for (int i = 1; i < 3; ++i) {
            const double across = std::abs(w[k][i - 1] - 2 * w[k][i] + w[k][i + 1]);
            const double down = std::abs(w[i - 1][k] - 2 * w[i][k] + w[i + 1][k]);
            // Not the larger of both, which of a number and NaN is the number.
            found.bend = across <= found.bend ? found.bend : across;
            found.bend = down <= found.bend ? found.bend : down;
            if (std::isnan(found.bend))
                return found;
        }
    return found;
}

/// The angle at the eye between the pixel's ray, along which the engine puts `shown_m`, and where what it shows is.
double shift_rad(const glm::dvec3& source_centre, double distance_m, const Pose& eye, const glm::dvec3& shown_m) {
    const glm::dvec3 direction = glm::normalize(shown_m - source_centre);
    const glm::dvec3 ray = glm::normalize(shown_m - eye.position_m);
    const glm::dvec3 seen =
        std::isinf(distance_m) ? direction : glm::normalize(source_centre + distance_m * direction - eye.position_m);
    return std::atan2(glm::length(glm::cross(ray, seen)), glm::dot(ray, seen));
}

class Measurement {
public:
    explicit Measurement(const Options& options)
        : options_(options), scene_(load_scene(options.scene)),
          depth_(options.model.empty() ? scene_ : load_scene(options.model)), truth_(scene_), eyes_(options, scene_) {
        sphere_depth_ = cast(depth_, eyes_.sphere, eyes_.centre);
        rgb_ = ByteImage(eyes_.sphere.width, eyes_.sphere.height, 3, 128);
    }

    nlohmann::json measure(const std::string& name) {
        const auto engine = make_engine(name);
        engine->set_source({.rgb = rgb_.view(),
                            .camera = eyes_.sphere,
                            .pose = eyes_.centre,
                            .depth_m = sphere_depth_.view(),
                            .box_radius_m = eyes_.box_radius_m});
        std::mt19937_64 generator = eyes_.generator();
        Shifts shifts;
        std::int64_t pixels = 0;
        for (int i = 0; i < eyes_.count; ++i) {
            add_shifts(*engine, eyes_.next(generator), shifts);
            pixels += std::int64_t(eyes_.eye.width) * eyes_.eye.height;
        }
        const double budget_px = EngineOptions{}.budget_px_of(name);
        return {{"engine", name},
                {"pixels", pixels},
                {"budget_px", budget_px},
                {"coloured", summary(shifts.coloured_px, budget_px)},
                {"smooth", summary(shifts.smooth_px, budget_px)},
                {"added", summary(shifts.added_px, budget_px)},
                {"sampled", summary(shifts.sampled_px, budget_px)}};
    }

private:
    struct Shifts {
        std::vector<float> coloured_px, smooth_px, added_px, sampled_px;
    };
    struct Pixel {
        float shift_px = -1;
        float added_px = 0;
        bool smooth = false, sampled = false;
    };

    /// What the source's samples around a direction tell of the distance there.
    Pixel told(float shift_px, const glm::dvec3& direction, double distance_m) const {
        const SampledW w = sampled_w(sphere_depth_, eyes_.sphere, eyes_.sphere.pixel(direction), eyes_.box_radius_m);
        const double error = std::abs(w.interpolated - bounded_inverse_depth(distance_m, eyes_.box_radius_m));
        const double budget = std::sin(error_budget_rad(eyes_.eye.focal_px()));
        const bool smooth = w.bend <= 8 * budget;
        const double explained_px = std::asin(std::min(error, 1.0)) * eyes_.eye.focal_px();
        return {shift_px, std::max(shift_px - float(explained_px), 0.0f), smooth, smooth && error <= budget};
    }

    void add_shifts(const Engine& engine, const Pose& pose, Shifts& shifts) {
        const FloatImage eye_depth = cast(depth_, eyes_.eye, pose);
        EyePicture picture;
        const bool given = engine.needs_depth(eyes_.centre, pose).eye;
        engine.reproject({eyes_.eye, pose, given ? eye_depth.view() : ImageView<const float>{}}, picture);
        const ImageView<const float> shown_m = given ? eye_depth.view() : std::as_const(picture.depth_m).view();
        const std::size_t columns = std::size_t(eyes_.eye.width);
        std::vector<Pixel> found(columns * std::size_t(eyes_.eye.height));
        tbb::parallel_for(0, eyes_.eye.height, [&](int y) {
            trace_thread_init();
            for (int x = 0; x < eyes_.eye.width; ++x) {
                if (*picture.origin.pixel(x, y) != std::uint8_t(PixelOrigin::source))
                    continue;
                const double depth_m = std::min<double>(shown_m.pixel(x, y)[0], 1e7);
                const glm::dvec3 ray = pose.orientation * eyes_.eye.direction(x + 0.5, y + 0.5);
                const glm::dvec3 point_m = pose.position_m + depth_m * ray;
                const glm::dvec3 direction = glm::normalize(point_m - eyes_.centre.position_m);
                const double distance_m = truth_.distance_m(eyes_.centre.position_m, direction);
                const double shift = shift_rad(eyes_.centre.position_m, distance_m, pose, point_m);
                found[std::size_t(y) * columns + std::size_t(x)] =
                    told(float(shift * eyes_.eye.focal_px()), direction, distance_m);
            }
        });
        for (const Pixel& pixel : found)
            if (pixel.shift_px >= 0) {
                shifts.coloured_px.push_back(pixel.shift_px);
                if (pixel.smooth) {
                    shifts.smooth_px.push_back(pixel.shift_px);
                    shifts.added_px.push_back(pixel.added_px);
                }
                if (pixel.sampled)
                    shifts.sampled_px.push_back(pixel.shift_px);
            }
    }

    static nlohmann::json summary(std::vector<float>& shifts_px, double budget_px) {
        if (shifts_px.empty())
            return {{"pixels", 0}};
        std::ranges::sort(shifts_px);
        const auto quantile = [&](double q) { return shifts_px[std::size_t(q * double(shifts_px.size() - 1))]; };
        const auto share_within = [&](double px) {
            return double(std::ranges::upper_bound(shifts_px, float(px)) - shifts_px.begin()) /
                   double(shifts_px.size());
        };
        return {{"pixels", shifts_px.size()},
                {"within_budget", share_within(budget_px)},
                {"within_twice_budget", share_within(2 * budget_px)},
                {"p50_px", quantile(0.5)},
                {"p99_px", quantile(0.99)},
                {"p999_px", quantile(0.999)},
                {"max_px", quantile(1)}};
    }

    Options options_;
    SceneDescription scene_;
    RayDepth depth_;
    Truth truth_;
    RandomEyes eyes_;
    FloatImage sphere_depth_;
    ByteImage rgb_;
};

void run(const Options& options) {
    Measurement measurement(options);
    nlohmann::json results = nlohmann::json::array();
    for (const std::string& engine : between_commas(options.engines))
        results.push_back(measurement.measure(engine));
    std::printf("%s\n", results.dump(1).c_str());
}

}  // namespace
}  // namespace equistream

int main(int argc, char** argv) {
    using namespace equistream;
    Options options;
    return cli::run_program(argc, argv,
                            {"measured_shift", "Measures how far engines displace what random eyes of the head box see",
                             "equistream_measured_shift scenes/descriptions/sibenik.json --frame 30"},
                            [&](cli::CommandLine& app) {
                                add_random_eye_options(app, options);
                                app.add_option("--model", options.model,
                                               "Client model that gives depth instead (equistream model)");
                                app.add_option("--engines", options.engines, "Comma-separated").with_default();
                                return [&options] { run(options); };
                            });
}
