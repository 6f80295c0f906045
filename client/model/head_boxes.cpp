#include "head_boxes.h"

#include <equistream/bound.h>
#include <scenes/library/polygon.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream {

namespace {

constexpr double max_centres = 512;

struct BoundingBall {
    glm::dvec3 centre;
    double radius;
};

BoundingBall bounding_ball(const TriangleCorners& t) {
    const glm::dvec3 centre = (glm::dvec3(t.a) + glm::dvec3(t.b) + glm::dvec3(t.c)) / 3.0;
    return {centre, std::max({glm::distance(centre, glm::dvec3(t.a)), glm::distance(centre, glm::dvec3(t.b)),
                              glm::distance(centre, glm::dvec3(t.c))})};
}

}  // namespace

HeadBoxes::HeadBoxes(const PosePath& path, double radius_m) : radius_m_(radius_m) {
    double length = 0;
    for (std::size_t i = 1; i < path.keys().size(); ++i)
        length += glm::distance(path.keys()[i].pose.position_m, path.keys()[i - 1].pose.position_m);
    const double step = std::max(radius_m, length / max_centres);
    centres_.push_back(path.keys().front().pose.position_m);
    for (const PosePath::Key& key : path.keys()) {
        const glm::dvec3 from = centres_.back(), to = key.pose.position_m;
        const int pieces = int(std::ceil(glm::distance(from, to) / step));
        for (int i = 1; i < pieces; ++i)
            centres_.push_back(glm::mix(from, to, double(i) / pieces));
        if (pieces > 1 || &key == &path.keys().back())
            centres_.push_back(to);
    }
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
    if (!(distance_m > radius_m_))
        return 0;
    const BoundingBall ball = bounding_ball(t);
    const glm::dvec3 cross = glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a));
    const double area = glm::length(cross);
    const glm::dvec3 normal = area > 0 ? cross / area : glm::dvec3(0);
    double allowed = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& c : centres_) {
        const double middle = glm::distance(c, ball.centre);
        const double r = std::max(distance_m, middle - ball.radius);
        const double from_plane = std::max(std::abs(glm::dot(normal, c - ball.centre)), 0.25 * radius_m_);
        allowed =
            std::min(allowed, allowed_displacement_m(r, std::min(1.0, from_plane / middle), radius_m_, error_rad));
    }
    return allowed;
}

glm::dvec3 HeadBoxes::random_centre(Random& random) const {
    const double at = random.unit() * double(centres_.size() - 1);
    const auto i = std::min(std::size_t(at), centres_.size() - 1);
    return i + 1 < centres_.size() ? glm::mix(centres_[i], centres_[i + 1], at - double(i)) : centres_[i];
}

}  // namespace equistream
