#include "proxy_sphere.h"

#include "eye_rays.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace equistream {

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
    const Vec3f from = rays.eye();
    const float beyond = float(radius_m * radius_m) - dot(from, from);
    tbb::parallel_for(0, inverse_planar.height(), [&](int y) {
        float* row = inverse_planar.pixel(0, y);
        for (int x = 0; x < inverse_planar.width(); ++x) {
            const Vec3f ray = rays.direction(x, y);
            const float along = dot(ray, from), square = dot(ray, ray);
            const float planar_m = (std::sqrt(along * along + square * beyond) - along) / square;
            row[x] = planar_m > 0 ? 1 / planar_m : nothing_found;
        }
    });
}

}  // namespace equistream
