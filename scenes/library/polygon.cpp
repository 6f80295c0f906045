#include "polygon.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace equistream {

namespace {

/// Newell's normal: right for polygons that are not quite flat, its length twice the area.
glm::dvec3 newell_normal(std::span<const glm::vec3> corners) {
    glm::dvec3 normal{0};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a(corners[i]), b(corners[(i + 1) % corners.size()]), origin(corners[0]);
        normal += glm::cross(a - origin, b - origin);
    }
    return normal;
}

double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Seen along the normal, counter-clockwise.
std::vector<glm::dvec2> flattened(std::span<const glm::vec3> corners, const glm::dvec3& normal) {
    const glm::dvec3 n = glm::abs(normal);
    const int drop = n.x > n.y ? (n.x > n.z ? 0 : 2) : (n.y > n.z ? 1 : 2);
    const int u = (drop + 1) % 3, v = (drop + 2) % 3;
    std::vector<glm::dvec2> flat;
    for (const glm::vec3& p : corners)
        flat.push_back(normal[drop] < 0 ? glm::dvec2(p[v], p[u]) : glm::dvec2(p[u], p[v]));
    return flat;
}

/// Of a simple polygon an ear that is cut changes only its neighbours' corners, so that each corner is judged three
/// times on average: quadratic work.
class EarClipper {
public:
    explicit EarClipper(std::vector<glm::dvec2> corners)
        : corners_(std::move(corners)), left_(corners_.size()), judged_(corners_.size(), Judged::not_yet) {
        std::iota(left_.begin(), left_.end(), 0u);
    }

    void clip(std::vector<std::array<std::uint32_t, 3>>& triangles) {
        std::size_t at = 0;
        // After a whole round without an ear the polygon is not simple: all is judged anew, a few times, and then
        // whatever comes next is cut off.
        for (std::size_t tried = 0; left_.size() > 3;) {
            const std::size_t n = left_.size();
            if (tried >= n && rounds_left_ > 0) {
                --rounds_left_;
                std::ranges::fill(judged_, Judged::not_yet);
                tried = 0;
            }
            if (tried < n && !is_ear((at + 1) % n)) {
                ++at;
                ++tried;
                continue;
            }
            const std::size_t before = at % n, tip = (at + 1) % n, after = (at + 2) % n;
            triangles.push_back({left_[before], left_[tip], left_[after]});
            judged_[left_[before]] = judged_[left_[after]] = Judged::not_yet;
            left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(tip));
            at %= left_.size();
            tried = tried < n ? 0 : n;  // given up once, given up for all
        }
        triangles.push_back({left_[0], left_[1], left_[2]});
    }

private:
    enum class Judged : std::uint8_t { not_yet, ear, none };

    bool is_ear(std::size_t tip) {
        Judged& judged = judged_[left_[tip]];
        if (judged == Judged::not_yet)
            judged = looks_like_ear(tip) ? Judged::ear : Judged::none;
        return judged == Judged::ear;
    }

    bool looks_like_ear(std::size_t tip) const {
        const std::size_t n = left_.size();
        const std::uint32_t a = left_[(tip + n - 1) % n], b = left_[tip], c = left_[(tip + 1) % n];
        const glm::dvec2 &p = corners_[a], &q = corners_[b], &r = corners_[c];
        if (!(turn(p, q, r) > 0))
            return false;
        const glm::dvec2 low = glm::min(glm::min(p, q), r), high = glm::max(glm::max(p, q), r);
        for (const std::uint32_t other : left_) {
            const glm::dvec2& o = corners_[other];
            if (o.x < low.x || o.x > high.x || o.y < low.y || o.y > high.y || other == a || other == b || other == c)
                continue;
            if (o == p || o == q || o == r)  // a hole's bridge meets its own corners
                continue;
            if (turn(p, q, o) >= 0 && turn(q, r, o) >= 0 && turn(r, p, o) >= 0)
                return false;
        }
        return true;
    }

    std::vector<glm::dvec2> corners_;
    std::vector<std::uint32_t> left_;
    std::vector<Judged> judged_;  // by corner
    int rounds_left_ = 8;
};

void cut_quadrangle(std::span<const glm::vec3> p, const glm::dvec3& normal,
                    std::vector<std::array<std::uint32_t, 3>>& triangles) {
    const auto faces_away = [&](int a, int b, int c) {
        const glm::dvec3 ab(p[static_cast<std::size_t>(b)] - p[static_cast<std::size_t>(a)]);
        const glm::dvec3 ac(p[static_cast<std::size_t>(c)] - p[static_cast<std::size_t>(a)]);
        return glm::dot(glm::cross(ab, ac), normal) < 0;
    };
    if (faces_away(0, 1, 2) || faces_away(0, 2, 3))
        triangles.insert(triangles.end(), {{1, 2, 3}, {1, 3, 0}});
    else
        triangles.insert(triangles.end(), {{0, 1, 2}, {0, 2, 3}});
}

}  // namespace

void triangulate(std::span<const glm::vec3> corners, std::vector<std::array<std::uint32_t, 3>>& triangles) {
    if (corners.size() < 3)
        return;
    if (corners.size() == 3) {
        triangles.push_back({0, 1, 2});
        return;
    }
    const glm::dvec3 normal = newell_normal(corners);
    if (corners.size() == 4)
        cut_quadrangle(corners, normal, triangles);
    else
        EarClipper(flattened(corners, normal)).clip(triangles);
}

}  // namespace equistream
