#pragma once
/// The folder of meshes and images, written aside and renamed when it is whole.
#include <equistream/locks.h>

#include <scenes/library/model.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream::mitsuba_xml {

/// Making files in it is thread-safe; the rest is not.
class AssetFolder {
public:
    /// NAME.files beside NAME.xml. Throws InputError if its parent is missing, or if it exists and may not be
    /// overwritten or holds something that no conversion wrote.
    AssetFolder(const std::filesystem::path& scene_file, bool overwrite);
    ~AssetFolder();
    AssetFolder(const AssetFolder&) = delete;
    AssetFolder& operator=(const AssetFolder&) = delete;

    /// Where a file is written now, and what the XML calls it.
    std::filesystem::path path_of(const std::string& name) const { return aside_ / name; }
    std::string reference_to(const std::string& name) const;

    void write_file(const std::string& name, std::span<const std::uint8_t> bytes);
    void count(std::uint64_t bytes) { bytes_ += bytes; }
    std::uint64_t bytes() const { return bytes_; }

    /// Puts it under its name, in the place of an earlier conversion's, if there is one. Until keep() that comes back
    /// should this object go.
    void place();
    void keep();

private:
    std::filesystem::path folder_, aside_, earlier_;
    std::optional<FolderLock> lock_;
    std::atomic<std::uint64_t> bytes_ = 0;
    bool placed_ = false, kept_ = false;
};

// Meshes as binary PLY, the form that Mitsuba reads fastest.

struct PlyPart {
    const Mesh* mesh = nullptr;
    glm::dmat4 world_from_object{1};  ///< applied to positions and normals; where it mirrors, the winding is turned
    std::uint32_t instance = 0;
};

struct PlyOptions {
    bool normals = true;              ///< vertex normals, where the first part's mesh has some
    bool texture_coordinates = true;  ///< zeros where a mesh has none: what our tracer takes
    bool instances = false;           ///< each part's, as the attribute face_instance
    double behind_m = 0;              ///< above 0: the other side, that far behind
};

/// One mesh of all parts, in their order: of all or none the meshes have vertex normals.
void write_ply(AssetFolder& folder, const std::string& name, std::span<const PlyPart> parts, const PlyOptions& options);

/// The largest angle's cosine between a vertex normal and a face it belongs to; 1 without normals.
double min_normal_cosine(const Mesh& mesh);

}  // namespace equistream::mitsuba_xml
