#include "plain_surface.h"

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

class Ray {
public:
    Ray(const PlainTask& task, const PlainSurface& surface, int x, int y)
        : task_(task), surface_(surface),
          direction_(glm::conjugate(task.source.pose.orientation) *
                     (task.eye.pose.orientation * task.eye.camera.direction(x + 0.5, y + 0.5))),
          eye_(glm::conjugate(task.source.pose.orientation) * task.eye_from_source_m()) {}

    /// By 1 / radial distance from the eye.
    double inverse_at(double s) const { return s / glm::length(direction_ + s * eye_); }
    glm::dvec2 pixel_at(double s) const { return pixel_of(task_.source.camera, direction_ + s * eye_); }

    /// The surface's 1 / distance in the direction of the point at s: bilinear where the four samples are joined, else
    /// the nearest one's own plane.
    double surface_at(double s) const {
        const glm::dvec2 p = pixel_at(s);
        if (!(p.x >= 0 && p.y >= 0 && p.x <= surface_.width() && p.y <= surface_.height()))
            return std::nan("");
        const int x = int(std::floor(p.x - 0.5)), y = int(std::floor(p.y - 0.5));
        const double a = p.x - 0.5 - x, b = p.y - 0.5 - y;
        bool whole = true;
        for (const int i : {0, 1})
            whole = whole && surface_.is_sample(x, y + i) && surface_.is_sample(x + 1, y + i) &&
                    surface_.is_sample(x + i, y) && surface_.is_sample(x + i, y + 1) &&
                    surface_.joined(x, y + i, 1, 0) && surface_.joined(x + i, y, 0, 1);
        if (whole) {
            // The mean of the four points, each with its direction: its k over its length.
            PlainPoint mean;
            for (int i = 0; i < 4; ++i) {
                const PlainPoint corner = surface_.point(x + i % 2, y + i / 2);
                const double weight = (i % 2 ? a : 1 - a) * (i / 2 ? b : 1 - b);
                mean = {mean.q + weight * corner.q, mean.k + weight * corner.k};
            }
            return mean.k / glm::length(mean.q);
        }
        const int nearest_x = int(std::floor(p.x)), nearest_y = int(std::floor(p.y));
        return std::max(surface_.continued(nearest_x, nearest_y, p.x - 0.5 - nearest_x, p.y - 0.5 - nearest_y), 0.0);
    }
    /// Positive behind the surface, negative before it.
    double behind(double s) const {
        const double k = surface_at(s);
        return std::isnan(k) ? -1 : k - inverse_at(s);
    }

private:
    const PlainTask& task_;
    const PlainSurface& surface_;
    glm::dvec3 direction_, eye_;
};

}  // namespace

/// Every ray is walked from the eye outwards in steps of a quarter of a pixel of the source; the first place where it
/// goes in through a surface, rather than past an edge, is what the eye sees.
void find_by_gather(const PlainTask& task, Image<double>& inverse_planar) {
    const PlainSurface surface(task);
    double nearest = 0, farthest = 1e30;
    for (int y = 0; y < surface.height(); ++y)
        for (int x = 0; x < surface.width(); ++x) {
            nearest = std::fmax(nearest, surface.inverse(x, y));
            farthest = std::fmin(farthest, surface.inverse(x, y));
        }
    const double distance_m = glm::length(task.eye_from_source_m());
    const double from = std::min(nearest / std::max(1 - nearest * distance_m, 1e-6), 1e3);
    const double to = 0.99999 * farthest / (1 + farthest * distance_m);
    const double pixel_rad = std::visit([](const auto& c) { return c.pixel_angle_rad(); }, task.source.camera);
    const int steps = std::max(2, int(4 * std::atan(distance_m * from) * 1.6 / pixel_rad));
    for (int y = 0; y < inverse_planar.height(); ++y)
        for (int x = 0; x < inverse_planar.width(); ++x) {
            const Ray ray(task, surface, x, y);
            double last = from * 1.00001 + 1e-9;
            double found = -1;
            for (int i = 0; i <= steps && found < 0; ++i) {
                // Exactly 0 for what is infinitely far: rounded to less, nothing would be behind it.
                const double s = i < steps ? from + (to - from) * i / steps : to;
                if (ray.behind(last) < 0 && ray.behind(s) >= 0) {
                    double near = last, far = s;
                    for (int n = 0; n < 50; ++n)
                        (ray.behind(0.5 * (near + far)) < 0 ? near : far) = 0.5 * (near + far);
                    if (surface.same(ray.surface_at(far), ray.inverse_at(far)))
                        found = far;
                }
                last = s;
            }
            if (found >= 0)
                *inverse_planar.pixel(x, y) = found / -task.eye.camera.direction(x + 0.5, y + 0.5).z;
        }
}

}  // namespace equistream
