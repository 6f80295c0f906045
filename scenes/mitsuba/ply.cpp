#include "ply.h"

#include <algorithm>
#include <array>
#include <bit>

namespace equistream::mitsuba_xml {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY files are written as the machine's own bytes");

/// The inverse transpose up to a positive factor: normals stay outside where a transform mirrors.
glm::dmat3 normal_matrix(const glm::dmat3& m) {
    const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
    return glm::determinant(m) < 0 ? -cofactors : cofactors;
}

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 0 ? v / length : glm::dvec3(0);
}

glm::dvec3 across(const Mesh& mesh, const glm::uvec3& t) {
    const glm::dvec3 a(mesh.positions[t.x]);
    return glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a);
}

/// By vertex: mean normal of its triangles, weighted by area.
std::vector<glm::dvec3> mean_normals(const Mesh& mesh) {
    std::vector<glm::dvec3> normals(mesh.positions.size(), glm::dvec3(0));
    for (const glm::uvec3& t : mesh.triangles)
        for (int corner = 0; corner < 3; ++corner)
            normals[t[corner]] += across(mesh, t);
    return normals;
}

std::string header(const Mesh& mesh, bool normals, bool uvs) {
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.positions.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\n";
    if (normals)
        text += "property float nx\nproperty float ny\nproperty float nz\n";
    if (uvs)
        text += "property float u\nproperty float v\n";
    return text + "element face " + std::to_string(mesh.triangles.size()) +
           "\nproperty list uchar uint vertex_indices\nend_header\n";
}

#pragma pack(push, 1)
struct Face {
    std::uint8_t count;
    std::uint32_t corners[3];
};
#pragma pack(pop)

}  // namespace

void write_ply(AssetFolder& folder, const std::string& name, const Mesh& mesh, const PlyOptions& options) {
    const glm::dmat3 linear(options.world_from_object);
    const glm::dmat3 turn = normal_matrix(linear);
    const bool other_side = options.behind_m > 0;
    const bool turned = (glm::determinant(linear) < 0) != other_side;
    const bool normals = options.normals && !mesh.normals.empty();
    const bool some_zero = normals && std::any_of(mesh.normals.begin(), mesh.normals.end(),
                                                  [](const glm::vec3& n) { return !(glm::dot(n, n) > 0); });
    const std::vector<glm::dvec3> means = other_side || some_zero ? mean_normals(mesh) : std::vector<glm::dvec3>();

    AssetFile file(folder.path_of(name));
    file.write(header(mesh, normals, options.texture_coordinates));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        std::array<float, 8> values{};
        std::size_t used = 0;
        const auto add = [&](const glm::dvec3& v) {
            for (int axis = 0; axis < 3; ++axis)
                values[used++] = static_cast<float>(v[axis]);
        };
        glm::dvec3 p(options.world_from_object * glm::dvec4(glm::dvec3(mesh.positions[i]), 1));
        if (other_side)
            p -= options.behind_m * unit_or_zero(turn * means[i]);
        add(p);
        if (normals) {
            const glm::dvec3 normal(mesh.normals[i]);
            const bool none = some_zero && !(glm::dot(normal, normal) > 0);
            add((other_side ? -1.0 : 1.0) * unit_or_zero(turn * (none ? means[i] : normal)));
        }
        if (options.texture_coordinates) {
            const glm::vec2 uv = mesh.uvs.empty() ? glm::vec2(0) : mesh.uvs[i];
            values[used++] = uv.x;
            values[used++] = uv.y;
        }
        file.write(values.data(), used * sizeof(float));
    }
    for (const glm::uvec3& t : mesh.triangles) {
        const Face face{3, {t.x, turned ? t.z : t.y, turned ? t.y : t.z}};
        file.write(&face, sizeof face);
    }
    folder.count(file.close());
}

double min_normal_cosine(const Mesh& mesh) {
    double least = 1;
    for (std::size_t i = 0; i < mesh.triangles.size() && !mesh.normals.empty(); ++i) {
        const glm::dvec3 face = across(mesh, mesh.triangles[i]);
        const double area = glm::length(face);
        for (int corner = 0; corner < 3 && area > 0; ++corner)
            least = std::min(least, glm::dot(face / area, glm::dvec3(mesh.normals[mesh.triangles[i][corner]])));
    }
    return least;
}

}  // namespace equistream::mitsuba_xml
