#pragma once
/// What a reader of OBJ and MTL made do with: one line for each kind of trouble, however often it is met.
#include "obj_files.h"

#include <tiny_obj_loader.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace equistream {

class ObjNotes {
public:
    /// `where` is "FILE:LINE"; notes of the same text are told once, with the place of the first.
    void add(const std::string& where, const std::string& text);
    /// In the order in which they came up.
    std::vector<std::string> lines() const;

private:
    struct Note {
        std::string where, text;
        int more = 0;
    };
    std::vector<Note> notes_;
    std::map<std::string, std::size_t> index_of_text_;
};

// An MTL file as tinyobjloader reads it, and what that does not tell: which statements were there, and on which lines.

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

/// Of one model, however many files they are in.
inline constexpr std::size_t material_limit = std::size_t{1} << 16;

/// Materials in the file's order. Statements that cannot be read are left out with a note.
std::vector<MtlMaterial> read_mtl(const std::filesystem::path& file, ObjNotes& notes);

}  // namespace equistream
