#include "head_boxes.h"

#include <equistream/bound.h>
#include <scenes/library/polygon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace equistream {

namespace {

/// Points of the path that are sorted into cells: this part of the radius apart, but no more than so many.
constexpr double sample_spacing = 0.25, max_samples = 1 << 20;
/// From one try of a grid to the next.
constexpr double coarser = 1.25;
/// Of random points. Of a long path's length, what one room takes is little.
constexpr double share_of_cells = 0.5;

struct BoundingBall {
    glm::dvec3 centre;
    double radius;
};

BoundingBall bounding_ball(const TriangleCorners& t) {
    const glm::dvec3 centre = (glm::dvec3(t.a) + glm::dvec3(t.b) + glm::dvec3(t.c)) / 3.0;
    return {centre, std::max({glm::distance(centre, glm::dvec3(t.a)), glm::distance(centre, glm::dvec3(t.b)),
                              glm::distance(centre, glm::dvec3(t.c))})};
}

/// Points no further apart than `step`. Keys nearer than that to the last point are left out; longer ways are divided.
std::vector<glm::dvec3> centres_along(std::span<const glm::dvec3> keys, double step) {
    std::vector<glm::dvec3> centres{keys.front()};
    for (const glm::dvec3& to : keys) {
        const glm::dvec3 from = centres.back();
        const int pieces = int(std::ceil(glm::distance(from, to) / step));
        for (int i = 1; i < pieces; ++i)
            centres.push_back(glm::mix(from, to, double(i) / pieces));
        if (pieces > 1 || &to == &keys.back())
            centres.push_back(to);
    }
    return centres;
}

/// Keys, and points between them no further apart than `step`.
std::vector<glm::dvec3> sampled(std::span<const glm::dvec3> keys, double step) {
    std::vector<glm::dvec3> samples{keys.front()};
    for (std::size_t k = 1; k < keys.size(); ++k) {
        const auto pieces =
            std::max(std::int64_t{1}, std::int64_t(std::ceil(glm::distance(keys[k - 1], keys[k]) / step)));
        for (std::int64_t i = 1; i <= pieces; ++i)
            samples.push_back(glm::mix(keys[k - 1], keys[k], double(i) / double(pieces)));
    }
    return samples;
}

/// Of the points that lie in one cell of a grid: the first, and the box around all.
struct Cell {
    glm::dvec3 first, low, high;
};

/// In the order that the points come to them; none where there would be more than `most`.
std::vector<Cell> cells_of(std::span<const glm::dvec3> points, double side, std::size_t most) {
    std::map<std::array<double, 3>, std::size_t> numbers;
    std::vector<Cell> cells;
    for (const glm::dvec3& point : points) {
        const glm::dvec3 corner = glm::floor(point / side);
        const std::array<double, 3> place{corner.x, corner.y, corner.z};
        const auto [entry, is_new] = numbers.try_emplace(place, cells.size());
        if (is_new && cells.size() == most)
            return {};
        if (is_new)
            cells.push_back({point, point, point});
        Cell& cell = cells[entry->second];
        cell.low = glm::min(cell.low, point);
        cell.high = glm::max(cell.high, point);
    }
    return cells;
}

}  // namespace

HeadBoxes::HeadBoxes(const PosePath& path, double radius_m, std::size_t max_centres) : radius_m_(radius_m) {
    double along = 0;
    for (const PosePath::Key& key : path.keys()) {
        if (!keys_.empty())
            along += glm::distance(keys_.back(), key.pose.position_m);
        keys_.push_back(key.pose.position_m);
        along_m_.push_back(along);
    }
    if (along <= radius_m * double(max_centres))
        centres_ = on_path_ = centres_along(keys_, radius_m);
    else
        take_cells(max_centres);
}

void HeadBoxes::take_cells(std::size_t max_centres) {
    const double step = std::max(sample_spacing * radius_m_, along_m_.back() / max_samples);
    const std::vector<glm::dvec3> samples = sampled(keys_, step);
    cell_m_ = radius_m_;
    std::vector<Cell> cells = cells_of(samples, cell_m_, max_centres);
    for (; cells.empty(); cells = cells_of(samples, cell_m_, max_centres))
        cell_m_ *= coarser;
    double furthest = 0;
    for (const Cell& cell : cells) {
        centres_.push_back(0.5 * (cell.low + cell.high));
        on_path_.push_back(cell.first);
        furthest = std::max(furthest, 0.5 * glm::distance(cell.low, cell.high));
    }
    if (cell_m_ > radius_m_)
        added_m_ = furthest + 0.5 * step;
}

double HeadBoxes::distance_m(const TriangleCorners& t) const {
    const BoundingBall ball = bounding_ball(t);
    double nearest = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& c : centres_)
        if (glm::distance(c, ball.centre) - ball.radius < nearest)
            nearest = std::min(nearest, distance_to_triangle(c, t.a, t.b, t.c));
    return nearest;
}

double HeadBoxes::allowed_m(const TriangleCorners& t, double distance_m, double error_rad) const {
    const double ball_m = radius_m_ + added_m_;
    if (!(distance_m > ball_m))
        return 0;
    const BoundingBall ball = bounding_ball(t);
    const glm::dvec3 cross = glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a));
    const double area = glm::length(cross);
    const glm::dvec3 normal = area > 0 ? cross / area : glm::dvec3(0);
    double allowed = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& c : centres_) {
        const double middle = glm::distance(c, ball.centre);
        const double r = std::max(distance_m, middle - ball.radius);
        const double from_plane = std::max(std::abs(glm::dot(normal, c - ball.centre)), 0.25 * ball_m);
        allowed = std::min(allowed, allowed_displacement_m(r, std::min(1.0, from_plane / middle), ball_m, error_rad));
    }
    return allowed;
}

glm::dvec3 HeadBoxes::random_centre(Random& random) const {
    if (cell_m_ > 0 && random.unit() < share_of_cells)
        return on_path_[std::size_t(random.unit() * double(on_path_.size()))];
    const double at = random.unit() * along_m_.back();
    const auto next = std::size_t(std::ranges::upper_bound(along_m_, at) - along_m_.begin());
    if (next == keys_.size())  // at its end, or of a path without length
        return keys_.back();
    const double from = along_m_[next - 1], to = along_m_[next];
    return glm::mix(keys_[next - 1], keys_[next], (at - from) / (to - from));
}

}  // namespace equistream
