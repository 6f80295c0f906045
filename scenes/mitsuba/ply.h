#pragma once
/// Meshes as binary PLY, the form that Mitsuba reads fastest.
#include "asset_folder.h"

#include <scenes/library/model.h>

namespace equistream::mitsuba_xml {

struct PlyOptions {
    glm::dmat4 world_from_object{1};  ///< applied to positions and normals; where it mirrors, the winding is turned
    bool normals = true;              ///< vertex normals, where the mesh has some
    bool texture_coordinates = true;  ///< zeros where the mesh has none: what our tracer takes
    double behind_m = 0;              ///< above 0: the other side, that far behind
};

void write_ply(AssetFolder& folder, const std::string& name, const Mesh& mesh, const PlyOptions& options);

/// The largest angle's cosine between a vertex normal and a face it belongs to; 1 without normals.
double min_normal_cosine(const Mesh& mesh);

}  // namespace equistream::mitsuba_xml
