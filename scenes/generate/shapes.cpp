#include "shapes.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace equistream::generate {
namespace {

/// A flat convex polygon; corners counter-clockwise from outside. uv: metres along the first edge and across it.
void add_polygon(Shape& shape, std::span<const glm::vec3> corners) {
    const glm::vec3 normal = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    const glm::vec3 along = glm::normalize(corners[1] - corners[0]);
    const glm::vec3 across = glm::cross(normal, along);
    const auto first = static_cast<unsigned>(shape.positions.size());
    for (const glm::vec3& p : corners) {
        shape.positions.push_back(p);
        shape.normals.push_back(normal);
        shape.uvs.emplace_back(glm::dot(p, along), -glm::dot(p, across));
    }
    for (unsigned i = 2; i < corners.size(); ++i)
        shape.triangles.emplace_back(first, first + i - 1, first + i);
}

void smooth_normals(Shape& shape, int columns, int rows, bool closed_u) {
    shape.normals.assign(shape.positions.size(), glm::vec3(0));
    for (const glm::uvec3& t : shape.triangles) {
        const glm::vec3 n =
            glm::cross(shape.positions[t.y] - shape.positions[t.x], shape.positions[t.z] - shape.positions[t.x]);
        for (int k = 0; k < 3; ++k)
            shape.normals[t[k]] += n;
    }
    for (int row = 0; closed_u && row <= rows; ++row) {
        glm::vec3& left = shape.normals[row * (columns + 1)];
        glm::vec3& right = shape.normals[row * (columns + 1) + columns];
        left = right = left + right;
    }
    for (glm::vec3& n : shape.normals)
        n = glm::dot(n, n) > 0 ? glm::normalize(n) : glm::vec3(0, 1, 0);
}

}  // namespace

void append(Shape& into, const Shape& part, const glm::mat4& transform) {
    const auto first = static_cast<unsigned>(into.positions.size());
    const glm::mat3 normal_transform = glm::transpose(glm::inverse(glm::mat3(transform)));
    const bool mirrored = glm::determinant(glm::mat3(transform)) < 0;
    for (const glm::vec3& p : part.positions)
        into.positions.emplace_back(transform * glm::vec4(p, 1));
    for (const glm::vec3& n : part.normals)
        into.normals.push_back(glm::normalize(normal_transform * n));
    into.uvs.insert(into.uvs.end(), part.uvs.begin(), part.uvs.end());
    for (const glm::uvec3& t : part.triangles)
        into.triangles.push_back((mirrored ? glm::uvec3(t.x, t.z, t.y) : t) + first);
}

Shape box(glm::vec3 size) {
    return bevelled_box(size, 0);
}

Shape bevelled_box(glm::vec3 size, float bevel) {
    const glm::vec3 h = 0.5f * size;
    const glm::vec3 i = h - bevel;
    Shape shape;
    // `along` x `across` = outwards; a face lies at +-h on its axis and reaches +-i on the other two.
    for (int axis = 0; axis < 3; ++axis) {
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        for (const float side : {-1.0f, 1.0f}) {
            const auto corner = [&](float s, float t) {
                glm::vec3 p;
                p[axis] = side * h[axis];
                p[a] = side * s * i[a];
                p[b] = t * i[b];
                return p;
            };
            add_polygon(shape, std::array{corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)});
        }
        if (bevel <= 0)
            continue;
        // The four edges along `axis`.
        for (const float s : {-1.0f, 1.0f})
            for (const float t : {-1.0f, 1.0f}) {
                const auto point = [&](float end, bool on_a) {
                    glm::vec3 p;
                    p[axis] = end * i[axis];
                    p[a] = s * (on_a ? h[a] : i[a]);
                    p[b] = t * (on_a ? i[b] : h[b]);
                    return p;
                };
                std::array quad{point(-1, true), point(1, true), point(1, false), point(-1, false)};
                if (s * t > 0)
                    std::reverse(quad.begin(), quad.end());
                add_polygon(shape, quad);
            }
    }
    for (int corner = 0; bevel > 0 && corner < 8; ++corner) {
        const glm::vec3 s(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        std::array triangle{s * glm::vec3(h.x, i.y, i.z), s * glm::vec3(i.x, h.y, i.z), s * glm::vec3(i.x, i.y, h.z)};
        if (s.x * s.y * s.z < 0)
            std::swap(triangle[1], triangle[2]);
        add_polygon(shape, triangle);
    }
    return shape;
}

Shape sheet(int columns, int rows, const std::function<glm::vec3(float, float)>& at, glm::vec2 uv_scale,
            bool closed_u) {
    Shape shape;
    for (int row = 0; row <= rows; ++row)
        for (int column = 0; column <= columns; ++column) {
            const glm::vec2 uv(static_cast<float>(column) / static_cast<float>(columns),
                               static_cast<float>(row) / static_cast<float>(rows));
            shape.positions.push_back(at(closed_u && column == columns ? 0 : uv.x, uv.y));
            shape.uvs.push_back(uv * uv_scale);
        }
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const auto a = static_cast<unsigned>(row * (columns + 1) + column);
            const auto b = a + static_cast<unsigned>(columns) + 1;
            const auto& p = shape.positions;
            // A collapsed row or column (a pole, an axis) has one triangle a cell.
            if (p[a] != p[a + 1])
                shape.triangles.emplace_back(a, a + 1, b + 1);
            if (p[b] != p[b + 1])
                shape.triangles.emplace_back(a, b + 1, b);
        }
    smooth_normals(shape, columns, rows, closed_u);
    return shape;
}

Shape lathe(std::span<const glm::vec2> outline, int segments) {
    assert(outline.size() >= 2);
    float largest = 0;
    for (const glm::vec2& p : outline)
        largest = std::max(largest, p.x);
    const auto outward = [&](std::size_t i) {
        const glm::vec2 d = glm::normalize(outline[i + 1] - outline[i]);
        return glm::vec2(d.y, -d.x);
    };
    const std::size_t strips = outline.size() - 1;
    const auto joined = [&](std::size_t i, std::size_t j) {
        const glm::vec2 a = outward(i), b = outward(j);
        return glm::dot(a, b) > 0.866f ? glm::normalize(a + b) : a;
    };
    Shape shape;
    float v = 0;
    for (std::size_t i = 0; i < strips; ++i) {
        const glm::vec2 ends[2] = {outline[i], outline[i + 1]};
        const glm::vec2 normals[2] = {i > 0 ? joined(i, i - 1) : outward(i),
                                      i + 1 < strips ? joined(i, i + 1) : outward(i)};
        const float v_end = v - glm::length(ends[1] - ends[0]);
        const auto first = static_cast<unsigned>(shape.positions.size());
        for (int s = 0; s <= segments; ++s) {
            const float turn = static_cast<float>(s) / static_cast<float>(segments);
            const float angle = tau * (s == segments ? 0 : turn);
            const glm::vec2 round(std::sin(angle), std::cos(angle));
            for (int e = 0; e < 2; ++e) {
                shape.positions.emplace_back(ends[e].x * round.x, ends[e].y, ends[e].x * round.y);
                shape.normals.emplace_back(normals[e].x * round.x, normals[e].y, normals[e].x * round.y);
                shape.uvs.emplace_back(turn * tau * largest, e == 0 ? v : v_end);
            }
        }
        for (unsigned s = 0; s < static_cast<unsigned>(segments); ++s) {
            const unsigned a = first + 2 * s;
            if (ends[0].x > 0)
                shape.triangles.emplace_back(a, a + 2, a + 1);
            if (ends[1].x > 0)
                shape.triangles.emplace_back(a + 2, a + 3, a + 1);
        }
        v = v_end;
    }
    return shape;
}

Shape sphere(float radius, int segments, int rings) {
    Shape shape = sheet(
        segments, rings,
        [&](float u, float v) {
            if (v == 0 || v == 1)
                return glm::vec3(0, v == 0 ? -radius : radius, 0);
            const double longitude = 6.283185307179586 * u, latitude = 3.141592653589793 * (v - 0.5);
            return glm::vec3(radius * std::cos(latitude) * std::sin(longitude), radius * std::sin(latitude),
                             radius * std::cos(latitude) * std::cos(longitude));
        },
        {1, 1}, true);
    for (std::size_t i = 0; i < shape.positions.size(); ++i) {
        shape.normals[i] = shape.positions[i] / radius;
        shape.uvs[i].y = 1 - shape.uvs[i].y;
    }
    return shape;
}

Shape ring(float inner, float outer, int segments) {
    Shape shape = sheet(
        segments, 1,
        [&](float u, float v) {
            const float angle = tau * u, radius = glm::mix(outer, inner, v);
            return glm::vec3(radius * std::sin(angle), 0, radius * std::cos(angle));
        },
        {1, 1}, true);
    for (std::size_t i = 0; i < shape.positions.size(); ++i)
        shape.uvs[i] = {shape.positions[i].x, shape.positions[i].z};
    return shape;
}

Shape tube(std::span<const glm::vec3> points, std::span<const float> radii, int sides) {
    assert(points.size() >= 2 && radii.size() == points.size());
    const std::size_t last = points.size() - 1;
    // One frame carried along the curve by projection, so that the tube does not twist.
    std::vector<glm::vec3> across(points.size()), along(points.size());
    std::vector<float> length(points.size(), 0.0f);
    glm::vec3 extrapolated(0.36f, 0.48f, 0.8f);
    for (std::size_t i = 0; i <= last; ++i) {
        along[i] = glm::normalize(points[std::min(i + 1, last)] - points[i == 0 ? 0 : i - 1]);
        extrapolated -= along[i] * glm::dot(extrapolated, along[i]);
        if (glm::dot(extrapolated, extrapolated) < 1e-6f)
            extrapolated = glm::cross(along[i], glm::vec3(0.6f, 0, 0.8f));
        across[i] = extrapolated = glm::normalize(extrapolated);
        if (i > 0)
            length[i] = length[i - 1] + glm::length(points[i] - points[i - 1]);
    }
    const float around = tau * *std::max_element(radii.begin(), radii.end());
    Shape shape = sheet(
        sides, static_cast<int>(last),
        [&](float u, float v) {
            const auto i = static_cast<std::size_t>(std::lround(v * static_cast<float>(last)));
            const float angle = tau * u;
            return points[i] +
                   radii[i] * (std::cos(angle) * across[i] + std::sin(angle) * glm::cross(along[i], across[i]));
        },
        {around, 1}, true);
    for (std::size_t k = 0; k < shape.uvs.size(); ++k)
        shape.uvs[k].y = -length[k / (static_cast<std::size_t>(sides) + 1)];
    return shape;
}

Shape inside_out(Shape shape) {
    for (glm::vec3& n : shape.normals)
        n = -n;
    for (glm::uvec3& t : shape.triangles)
        std::swap(t.y, t.z);
    return shape;
}

Shape v_turned(Shape shape) {
    for (glm::vec2& uv : shape.uvs)
        uv.y = 1 - uv.y;
    return shape;
}

Shape card(float width, float height) {
    return v_turned(
        sheet(1, 1, [&](float u, float v) { return glm::vec3((u - 0.5f) * width, (v - 0.5f) * height, 0); }));
}

}  // namespace equistream::generate
