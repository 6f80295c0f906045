#pragma once
/// Meshes of simple shapes, in metres, normals outwards, counter-clockwise from outside, material left to the caller.
/// Texture coordinates are in metres along the surface unless said otherwise, so that one texture scale fits all.
#include <scenes/library/model.h>

#include <functional>
#include <span>

namespace equistream::generate {

using Shape = Mesh;

inline constexpr float tau = 6.2831853f;

/// Adds `part`, transformed, to `into`. Both have normals and uvs.
void append(Shape& into, const Shape& part, const glm::mat4& transform = glm::mat4(1));

/// A box centred at the origin, six separate faces.
Shape box(glm::vec3 size);
/// A box whose edges are cut by `bevel` metres at 45 degrees, so that edges catch light.
Shape bevelled_box(glm::vec3 size, float bevel);

/// A sheet of (columns + 1) x (rows + 1) points at(u, v), u and v in [0, 1], with smooth normals (du x dv is outwards).
/// `uv_scale` multiplies (u, v). `closed_u`: u = 0 and u = 1 are the same place; their normals are merged.
Shape sheet(int columns, int rows, const std::function<glm::vec3(float, float)>& at, glm::vec2 uv_scale = {1, 1},
            bool closed_u = false);

/// Turns an outline of (radius, height) points round the Y axis, from the bottom up on the outside. Corners sharper
/// than 30 degrees stay sharp. u runs round the axis at the largest radius, v along the outline.
Shape lathe(std::span<const glm::vec2> outline, int segments);

/// Triangles all have corners on the sphere. u = longitude / 2 pi, v = 0 at the top.
Shape sphere(float radius, int segments, int rings);

/// A flat ring (a disc if `inner` is 0) in the XZ plane facing up; uv = (x, z).
Shape ring(float inner, float outer, int segments);

/// A tube through `points` with one radius each, `sides` round; open ends. Points are joined straight.
Shape tube(std::span<const glm::vec3> points, std::span<const float> radii, int sides);

/// The same shape seen from inside: normals and winding turned.
Shape inside_out(Shape shape);

/// The same shape with v running the other way: from 1 to 0.
Shape v_turned(Shape shape);

/// A rectangle of width x height centred at the origin in the XY plane, facing +Z; uv in [0, 1], v down.
Shape card(float width, float height);

}  // namespace equistream::generate
