#pragma once
/// Whole files as bytes, with a limit, and a content hash over them.
#include "scene.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace equistream {

/// Opens a regular file; InputError names the file and `what` it was to be ("model") if there is none to be read.
std::ifstream open_regular_file(const std::filesystem::path& file, const std::string& what);

/// Reads a regular file of at most `limit_bytes`; InputError names the file and `what` it was to be ("model").
std::vector<std::uint8_t> read_file_bytes(const std::filesystem::path& file, const std::string& what,
                                          std::uint64_t limit_bytes);

/// InputError above 4 GiB: a small model may name large files thousands of times.
void require_at_most_4_gib(std::uint64_t bytes, const std::string& where, const std::string& what);

/// XXH64 chained over everything added; not cryptographic, stable between runs and machines of one byte order.
class ContentHash {
public:
    void add(std::span<const std::uint8_t> bytes);
    void add(const std::string& text);
    /// Streams a file through, a block at a time.
    void add_file(const std::filesystem::path& file, const std::string& what);
    /// 16 hexadecimal digits.
    std::string hex() const;

private:
    std::uint64_t state_ = 0;
};

// The bytes that depth comes from, hashed.

/// Of the model file, the files beside it that it names (buffers and images of a .gltf or .glb; of an .obj its MTL
/// files and their images), its unit, and the moving objects' paths: all by content. Files that are missing are left
/// for load_model to complain about.
std::string geometry_fingerprint(const std::filesystem::path& model, double model_unit_m,
                                 const std::vector<MovingObject>& moving);

}  // namespace equistream
