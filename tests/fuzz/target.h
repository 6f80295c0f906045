#pragma once
/// What is fuzzed. A target reads bytes that came from outside; it may return or throw an InputError or WorkError of
/// one line. Anything else (another exception, a sanitizer's report, a claim that does not hold) is a find.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::fuzz {

using Bytes = std::span<const std::uint8_t>;
using Seeds = std::vector<std::vector<std::uint8_t>>;

struct Target {
    std::string_view name;
    void (*read)(Bytes);
    Seeds (*seeds)();  ///< small whole inputs, the same every time
    int rounds;        ///< of each kind of damage that fuzz_test tries: about a second's work
};

std::span<const Target> targets();

/// Runs the target on its own exact-size copy of the bytes. Whether they were accepted; throws for a find.
bool accepts(const Target& target, Bytes bytes);

/// Throws std::logic_error: what was read does not keep its promise.
void require(bool holds, const char* promise);

/// `bytes` as a file of this process's own temporary folder; the same name is the same file.
std::filesystem::path scratch_file(const std::string& name, Bytes bytes);

/// For seeds.
std::vector<std::uint8_t> bytes_of(std::string_view text);
std::vector<std::uint8_t> bytes_of_file(const std::filesystem::path& file);

// One a file.
extern const Target frame_data_target;
extern const Target manifest_target;
extern const Target scene_target;
extern const Target path_target;
extern const Target model_target;
extern const Target obj_target;
extern const Target exr_target;
extern const Target foreign_exr_target;
extern const Target stream_target;

}  // namespace equistream::fuzz
