#include "plain_surface.h"

#include <algorithm>
#include <array>
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

namespace {

class Raster {
public:
    Raster(const PlainSurface& surface, bool both_sides, Image<double>& inverse_planar)
        : surface_(surface), both_sides_(both_sides), inverse_planar_(inverse_planar) {}

    /// Whichever way round only if `either_way`. Triangles that reach behind the eye are left out: one pixel wide, they
    /// do so outside its view.
    void triangle(const PlainPoint& a, const PlainPoint& b, const PlainPoint& c, bool either_way) {
        const PlainEyePoint p = surface_.project(a), q = surface_.project(b), r = surface_.project(c);
        if (!(p.inverse_planar >= 0 && q.inverse_planar >= 0 && r.inverse_planar >= 0))
            return;
        const glm::dmat2 sides(q.pixel - p.pixel, r.pixel - p.pixel);
        const double area = glm::determinant(sides);
        if (area == 0 || (area < 0 && !either_way && !both_sides_))
            return;
        const glm::dmat2 inverse = glm::inverse(sides);
        const glm::dvec2 low = glm::min(p.pixel, glm::min(q.pixel, r.pixel));
        const glm::dvec2 high = glm::max(p.pixel, glm::max(q.pixel, r.pixel));
        const glm::dvec2 last(inverse_planar_.width() - 1, inverse_planar_.height() - 1);
        const glm::ivec2 from(glm::clamp(glm::floor(low) - 1.0, glm::dvec2(0), last));
        const glm::ivec2 to(glm::clamp(glm::ceil(high), glm::dvec2(0), last));
        for (int j = from.y; j <= to.y; ++j)
            for (int i = from.x; i <= to.x; ++i) {
                const glm::dvec2 share = inverse * (glm::dvec2(i + 0.5, j + 0.5) - p.pixel);
                if (share.x < -1e-9 || share.y < -1e-9 || share.x + share.y > 1 + 1e-9)
                    continue;
                double& nearest = *inverse_planar_.pixel(i, j);
                nearest = std::max(nearest, (1 - share.x - share.y) * p.inverse_planar + share.x * q.inverse_planar +
                                                share.y * r.inverse_planar);
            }
    }

private:
    const PlainSurface& surface_;
    bool both_sides_;
    Image<double>& inverse_planar_;
};

PlainPoint mean(const PlainPoint& a, const PlainPoint& b) {
    return {0.5 * (a.q + b.q), 0.5 * (a.k + b.k)};
}

/// The cells of a lattice, cut ones as the quarters of their corners.
class Cells {
public:
    Cells(const PlainSurface& surface, Raster& raster) : surface_(surface), raster_(raster) {}

    void draw(int x, int y, bool plain) {
        const std::array<std::array<int, 2>, 4> at{{{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}}};
        const std::array<bool, 4> joined{surface_.joined(x, y, 1, 0), surface_.joined(x + 1, y, 0, 1),
                                         surface_.joined(x, y + 1, 1, 0), surface_.joined(x, y, 0, 1)};
        std::array<PlainPoint, 4> p;
        for (int i = 0; i < 4; ++i)
            p[i] = surface_.edge_point(at[i][0], at[i][1]);
        const bool over_pole = y < 0;
        if (plain || (joined[0] && joined[1] && joined[2] && joined[3])) {
            raster_.triangle(p[0], p[1], p[2], over_pole);
            raster_.triangle(p[0], p[2], p[3], over_pole);
            return;
        }
        std::array<int, 4> part{0, 1, 2, 3};
        for (int i = 0; i < 4; ++i)
            if (joined[i]) {
                const int from = part[(i + 1) % 4], to = part[i];
                std::ranges::replace(part, from, to);
            }
        PlainPoint centre;
        for (const PlainPoint& corner : p)
            centre.q += 0.25 * corner.q;
        for (int i = 0; i < 4; ++i) {
            if (std::isnan(p[i].k))
                continue;
            double sum = 0;
            int count = 0;
            for (int j = 0; j < 4; ++j)
                if (part[j] == part[i]) {
                    sum += continued(at[j], x, y);
                    ++count;
                }
            centre.k = std::max(sum / count, 0.0);
            const int next = (i + 1) % 4, last = (i + 3) % 4;
            raster_.triangle(p[i], halfway(at[i], at[next], joined[i]), centre, over_pole);
            raster_.triangle(p[i], centre, halfway(at[i], at[last], joined[last]), over_pole);
        }
    }

private:
    double continued(const std::array<int, 2>& corner, int x, int y) const {
        return surface_.continued(corner[0], corner[1], corner[0] == x ? 0.5 : -0.5, corner[1] == y ? 0.5 : -0.5);
    }
    PlainPoint halfway(const std::array<int, 2>& from, const std::array<int, 2>& to, bool joined) const {
        PlainPoint half = mean(surface_.edge_point(from[0], from[1]), surface_.edge_point(to[0], to[1]));
        if (!joined)
            half.k =
                std::max(surface_.continued(from[0], from[1], 0.5 * (to[0] - from[0]), 0.5 * (to[1] - from[1])), 0.0);
        return half;
    }

    const PlainSurface& surface_;
    Raster& raster_;
};

}  // namespace

/// Every cell of the lattice, each for itself.
void find_by_mesh(const PlainTask& task, bool plain, Image<double>& inverse_planar) {
    const PlainSurface surface(task);
    Raster raster(surface, plain, inverse_planar);
    Cells cells(surface, raster);
    for (int y = -1; y < surface.height(); ++y)
        for (int x = surface.closes() ? 0 : -1; x < surface.width(); ++x)
            cells.draw(x, y, plain);
}

}  // namespace equistream::plain
