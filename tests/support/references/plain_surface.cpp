#include "plain_surface.h"

#include <algorithm>
#include <cmath>

namespace equistream::plain {

PlainSurface::PlainSurface(const PlainTask& task)
    : task_(task), width_(task.source.depth_m.width), height_(task.source.depth_m.height), box_m_(task.box_radius_m()),
      tolerance_(std::sin(task.tolerance_rad())) {
    if (const auto* sphere = std::get_if<EquirectCamera>(&task.source.camera)) {
        closes_ = sphere->range.closes();
        north_pole_ = closes_ && sphere->range.latitude_max > pi / 2 - 1e-9;
        south_pole_ = closes_ && sphere->range.latitude_min < -pi / 2 + 1e-9;
    }
}

bool PlainSurface::is_sample(int x, int y) const {
    const bool row = (y >= 0 || north_pole_) && (y < height_ || south_pole_);
    return row && (closes_ || (x >= 0 && x < width_));
}

double PlainSurface::inverse(int x, int y) const {
    if (!is_sample(x, y))
        return std::nan("");
    if (y < 0 || y >= height_) {
        y = y < 0 ? -1 - y : 2 * height_ - 1 - y;
        x += width_ / 2;
    }
    const double depth_m = task_.source.depth_m.pixel((x % width_ + width_) % width_, y)[0];
    return depth_m > 0 ? 1 / depth_m : std::nan("");
}

glm::dvec3 PlainSurface::direction(int x, int y) const {
    if (y < 0 ? north_pole_ : y >= height_ && south_pole_) {
        y = y < 0 ? -1 - y : 2 * height_ - 1 - y;
        x += width_ / 2;
    }
    return direction_of(task_.source.camera, x + 0.5, y + 0.5);
}

PlainPoint PlainSurface::edge_point(int x, int y) const {
    if (is_sample(x, y))
        return point(x, y);
    // A column round the seam may still be beyond the picture's rows.
    const int inner_x = closes_ ? x : std::clamp(x, 0, width_ - 1), inner_y = std::clamp(y, 0, height_ - 1);
    const int behind_x = closes_ ? x : std::clamp(2 * inner_x - x, 0, width_ - 1);
    const int behind_y = std::clamp(2 * inner_y - y, 0, height_ - 1);
    const double u = closes_ ? x + 0.5 : std::clamp(x + 0.5, 0.0, double(width_));
    const double v = std::clamp(y + 0.5, 0.0, double(height_));
    const double k = 1.5 * inverse(inner_x, inner_y) - 0.5 * inverse(behind_x, behind_y);
    return {direction_of(task_.source.camera, u, v), std::isnan(k) ? k : std::max(k, 0.0)};
}

double PlainSurface::w(double inverse) const {
    if (inverse == 0)
        return 0;
    const double r = 1 / inverse;
    return box_m_ / std::max(r - box_m_, 1e-3 * r);
}

double PlainSurface::edge_or_sample(int x, int y) const {
    const bool on_edge = x >= -1 && y >= -1 && x <= width_ && y <= height_;
    return is_sample(x, y) ? inverse(x, y) : on_edge ? edge_point(x, y).k : std::nan("");
}

bool PlainSurface::joined(int x, int y, int dx, int dy) const {
    const double before = edge_or_sample(x - dx, y - dy), a = edge_or_sample(x, y);
    const double b = edge_or_sample(x + dx, y + dy), after = edge_or_sample(x + 2 * dx, y + 2 * dy);
    const auto explained = [&](double from, double led_to, double to) {
        return same(from, to) || same(std::max(led_to, 0.0), to) || (from < to && to < led_to) ||
               (led_to < to && to < from);
    };
    return explained(a, 2 * a - before, b) || explained(b, 2 * b - after, a);
}

double PlainSurface::continued(int x, int y, double du, double dv) const {
    const double here = inverse(x, y);
    const auto slope = [&](int dx, int dy, double towards) {
        const bool before = is_sample(x - dx, y - dy) && joined(x - dx, y - dy, dx, dy);
        const bool after = is_sample(x + dx, y + dy) && joined(x, y, dx, dy);
        if (after && (towards > 0 || !before))
            return inverse(x + dx, y + dy) - here;
        return before ? here - inverse(x - dx, y - dy) : 0;
    };
    return here + du * slope(1, 0, du) + dv * slope(0, 1, dv);
}

PlainEyePoint PlainSurface::project(const PlainPoint& p) const {
    const glm::dvec3 from_eye = glm::conjugate(task_.eye.pose.orientation) *
                                (task_.source.pose.orientation * p.q - p.k * task_.eye_from_source_m());
    if (!(from_eye.z < 0))
        return {glm::dvec2(std::nan("")), std::nan("")};
    return {task_.eye.camera.pixel(from_eye), p.k / -from_eye.z};
}

}  // namespace equistream::plain
