#pragma once
/// An MTL file as tinyobjloader reads it, and what that does not tell: which statements were there, and on which lines.
#include "obj_files.h"
#include "obj_notes.h"

#include <tiny_obj_loader.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace equistream {

struct MtlMaterial {
    tinyobj::material_t values;                  ///< all but its textures
    std::map<std::string, ObjTexture> textures;  ///< by statement
    std::string file;
    int line = 0;                        ///< of its newmtl
    std::map<std::string, int> line_of;  ///< by statement, in the usual spelling ("map_Kd"): the line it was last on
    float tr = 0;                        ///< the number after Tr

    bool gives(const std::string& statement) const { return line_of.contains(statement); }
    /// "FILE:LINE" of a statement that is there.
    std::string where(const std::string& statement) const { return file + ":" + std::to_string(line_of.at(statement)); }
};

/// Materials in the file's order. Statements that cannot be read are left out with a note.
std::vector<MtlMaterial> read_mtl(const std::filesystem::path& file, ObjNotes& notes);

}  // namespace equistream
