#include "asset_folder.h"

#include <equistream/error.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>

namespace equistream::mitsuba_xml {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const fs::path& file, const std::string& reason) {
    throw WorkError(file.string() + ": cannot be written: " + reason);
}

/// One file, from front to back. Failures throw WorkError naming the file.
class AssetFile {
public:
    explicit AssetFile(fs::path file) : file_(std::move(file)), stream_(std::fopen(file_.c_str(), "wbe")) {
        if (!stream_)
            fail(file_, std::strerror(errno));
    }
    void write(const void* data, std::size_t bytes) {
        if (std::fwrite(data, 1, bytes, stream_.get()) != bytes)
            fail(file_, std::strerror(errno));
        bytes_ += bytes;
    }
    /// Returns the file's bytes.
    std::uint64_t close() {
        if (std::fclose(stream_.release()) != 0)
            fail(file_, std::strerror(errno));
        return bytes_;
    }

private:
    struct Close {
        void operator()(std::FILE* stream) const { std::fclose(stream); }
    };
    fs::path file_;
    std::unique_ptr<std::FILE, Close> stream_;
    std::uint64_t bytes_ = 0;
};

fs::path folder_for(const fs::path& scene_file) {
    // "$" would start a parameter in Mitsuba's XML.
    std::string name = scene_file.stem().string() + ".files";
    std::replace(name.begin(), name.end(), '$', '_');
    return scene_file.parent_path() / name;
}

/// Whether a conversion writes files with this extension: nothing else may be deleted with the folder.
bool is_ours(const fs::path& file) {
    static constexpr const char* extensions[] = {".ply", ".png", ".jpg", ".exr"};
    return std::find(std::begin(extensions), std::end(extensions), file.extension()) != std::end(extensions);
}

void require_ours(const fs::path& folder) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (!entry.is_regular_file() || !is_ours(entry.path()))
            throw InputError(expected_found(folder.string(), "a folder that an earlier conversion wrote",
                                            entry.path().filename().string() + " in it"));
}

}  // namespace

AssetFolder::AssetFolder(const fs::path& scene_file, bool overwrite) : folder_(folder_for(scene_file)) {
    const fs::path parent = folder_.has_parent_path() ? folder_.parent_path() : fs::path(".");
    std::error_code error;
    if (!fs::is_directory(parent, error))
        throw InputError(expected_found(scene_file.string(), "a folder to write to", "none at " + parent.string()));
    for (const fs::path& there : {scene_file, folder_})
        if (!overwrite && fs::exists(fs::symlink_status(there, error)))
            throw InputError(expected_found(there.string(), "no earlier output, or --overwrite", "one"));
    if (fs::exists(folder_, error))
        require_ours(folder_);
    aside_ = parent / ("." + folder_.filename().string() + ".aside");
    fs::create_directory(aside_, error);
    if (error)
        fail(aside_, error.message());
    if (!fs::is_directory(fs::symlink_status(aside_)))
        throw InputError(expected_found(aside_.string(), "a folder of an earlier conversion", "a symbolic link"));
    lock_.emplace(aside_);
    earlier_ = parent / ("." + folder_.filename().string() + ".earlier.aside");
    // Of a run that was killed between two names.
    if (fs::exists(earlier_, error) && !fs::exists(folder_, error))
        fs::rename(earlier_, folder_, error);
    if (error)
        fail(folder_, error.message());
    fs::remove_all(earlier_, error);
    for (const fs::directory_entry& left_behind : fs::directory_iterator(aside_))
        fs::remove_all(left_behind.path(), error);
}

AssetFolder::~AssetFolder() {
    std::error_code error;
    if (kept_ || !lock_)
        return;
    fs::remove_all(placed_ ? folder_ : aside_, error);
    if (fs::exists(earlier_, error) && !fs::exists(folder_, error))
        fs::rename(earlier_, folder_, error);
}

std::string AssetFolder::reference_to(const std::string& name) const {
    return folder_.filename().string() + "/" + name;
}

void AssetFolder::write_file(const std::string& name, std::span<const std::uint8_t> bytes) {
    AssetFile file(path_of(name));
    file.write(bytes.data(), bytes.size());
    count(file.close());
}

void AssetFolder::place() {
    std::error_code error;
    if (fs::exists(folder_, error))
        fs::rename(folder_, earlier_, error);
    if (!error)
        fs::rename(aside_, folder_, error);
    if (error)
        fail(folder_, error.message());
    placed_ = true;
}

void AssetFolder::keep() {
    std::error_code error;
    fs::remove_all(earlier_, error);
    kept_ = true;
}

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

std::string header(std::span<const PlyPart> parts, bool normals, const PlyOptions& options) {
    std::size_t vertices = 0, faces = 0;
    for (const PlyPart& part : parts) {
        vertices += part.mesh->positions.size();
        faces += part.mesh->triangles.size();
    }
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(vertices) +
                       "\nproperty float x\nproperty float y\nproperty float z\n";
    if (normals)
        text += "property float nx\nproperty float ny\nproperty float nz\n";
    if (options.texture_coordinates)
        text += "property float u\nproperty float v\n";
    text += "element face " + std::to_string(faces) + "\nproperty list uchar uint vertex_indices\n";
    // Mitsuba puts face_ before the name, and takes what follows the last line for a component's.
    return text + (options.instances ? "property float instance_0\n" : "") + "end_header\n";
}

void write_vertices(AssetFile& file, const PlyPart& part, bool normals, const PlyOptions& options) {
    const Mesh& mesh = *part.mesh;
    const glm::dmat3 turn = normal_matrix(glm::dmat3(part.world_from_object));
    const bool other_side = options.behind_m > 0;
    const bool some_zero = normals && std::any_of(mesh.normals.begin(), mesh.normals.end(),
                                                  [](const glm::vec3& n) { return !(glm::dot(n, n) > 0); });
    const std::vector<glm::dvec3> means = other_side || some_zero ? mean_normals(mesh) : std::vector<glm::dvec3>();
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        std::array<float, 8> values{};
        std::size_t used = 0;
        const auto add = [&](const glm::dvec3& v) {
            for (int axis = 0; axis < 3; ++axis)
                values[used++] = static_cast<float>(v[axis]);
        };
        glm::dvec3 p(part.world_from_object * glm::dvec4(glm::dvec3(mesh.positions[i]), 1));
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
}

#pragma pack(push, 1)
struct Face {
    std::uint8_t count;
    std::uint32_t corners[3];
    float instance;  ///< where it is wanted
};
#pragma pack(pop)

void write_faces(AssetFile& file, const PlyPart& part, std::uint32_t first_vertex, const PlyOptions& options) {
    const bool turned = (glm::determinant(glm::dmat3(part.world_from_object)) < 0) != (options.behind_m > 0);
    for (const glm::uvec3& triangle : part.mesh->triangles) {
        const glm::uvec3 t = triangle + first_vertex;
        const Face face{3, {t.x, turned ? t.z : t.y, turned ? t.y : t.z}, static_cast<float>(part.instance)};
        file.write(&face, options.instances ? sizeof face : offsetof(Face, instance));
    }
}

}  // namespace

void write_ply(AssetFolder& folder, const std::string& name, std::span<const PlyPart> parts,
               const PlyOptions& options) {
    const bool normals = options.normals && !parts.front().mesh->normals.empty();
    AssetFile file(folder.path_of(name));
    const std::string beginning = header(parts, normals, options);
    file.write(beginning.data(), beginning.size());
    for (const PlyPart& part : parts)
        write_vertices(file, part, normals, options);
    std::uint32_t first_vertex = 0;
    for (const PlyPart& part : parts) {
        write_faces(file, part, first_vertex, options);
        first_vertex += static_cast<std::uint32_t>(part.mesh->positions.size());
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
