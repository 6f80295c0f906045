#pragma once
/// Which other files an OBJ names, found although their names are not quite right: backslashes, another case, a folder
/// of the machine they were made on.
#include <glm/glm.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

bool is_obj(const std::filesystem::path& model);

/// The file that `name` means, relative to `folder`: as written, with slashes for backslashes, in any case of ASCII
/// letters, in UTF-8 if it is written in Latin-1, and last by its name alone. Nothing if there is none.
std::optional<std::filesystem::path> find_named_file(const std::filesystem::path& folder, const std::string& name);

/// Files that an `mtllib` statement names: names may hold blanks, so all of it is tried before its words are.
/// Those that are not there are left out.
std::vector<std::filesystem::path> find_material_files(const std::filesystem::path& folder, const std::string& names);

/// A texture statement: "-s 2 2 1 wood.tga".
struct ObjTexture {
    std::string name;               ///< as written; empty if there is none
    glm::vec2 scale{1}, offset{0};  ///< of texture coordinates, -s and -o
    bool clamp = false;
};

ObjTexture parse_texture(const std::string& statement);

/// The MTL files that an OBJ names and the images that those name, as far as they are there.
std::vector<std::filesystem::path> files_of_obj(const std::filesystem::path& model);

}  // namespace equistream
