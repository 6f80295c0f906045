#include "target.h"

#include <equistream/error.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace equistream::fuzz {

namespace {

class ScratchFolder {
public:
    ScratchFolder() {
        // In memory where there is such a folder: files are written by the thousand.
        const std::filesystem::path memory = "/dev/shm";
        const std::filesystem::path place =
            std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
        std::string name = (place / "equistream-fuzz-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr)
            throw std::runtime_error("no temporary folder");
        path_ = name;
    }
    ~ScratchFolder() { std::filesystem::remove_all(path_); }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

void check_refusal(const std::string& line) {
    require(!line.empty() && line.size() < 10000, "a refusal is neither empty nor endless");
    for (const char c : line)
        require(static_cast<unsigned char>(c) >= 0x20, "a refusal is one line without control characters");
}

}  // namespace

std::span<const Target> targets() {
    static const std::array all = {frame_data_target, manifest_target, scene_target,       path_target,  model_target,
                                   obj_target,        exr_target,      foreign_exr_target, stream_target};
    return all;
}

bool accepts(const Target& target, Bytes bytes) {
    const std::vector<std::uint8_t> copy(bytes.begin(), bytes.end());
    try {
        target.read(copy);
        return true;
    } catch (const InputError& refusal) {
        check_refusal(refusal.what());
    } catch (const WorkError& refusal) {
        check_refusal(refusal.what());
    }
    return false;
}

void require(bool holds, const char* promise) {
    if (!holds)
        throw std::logic_error(promise);
}

std::filesystem::path scratch_file(const std::string& name, Bytes bytes) {
    static const ScratchFolder folder;
    const std::filesystem::path file = folder.path() / name;
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    require(out.good(), "the temporary folder can be written");
    return file;
}

std::vector<std::uint8_t> bytes_of(std::string_view text) {
    return {text.begin(), text.end()};
}

std::vector<std::uint8_t> bytes_of_file(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    require(!text.empty(), "a seed was written");
    return bytes_of(text);
}

}  // namespace equistream::fuzz
