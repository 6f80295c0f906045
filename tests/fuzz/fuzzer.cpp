/// libFuzzer's entry. The program's name, fuzz_NAME, says which target it is. `--seeds FOLDER` writes the target's
/// seeds and ends.
#include "target.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

using namespace equistream::fuzz;

namespace {

const Target* target = nullptr;

const Target* target_of(const std::filesystem::path& program) {
    constexpr std::string_view prefix = "fuzz_";
    const std::string name = program.filename().string();
    const auto found = std::ranges::find_if(targets(), [&](const Target& one) {
        return name.starts_with(prefix) && name.substr(prefix.size()) == one.name;
    });
    return found == targets().end() ? nullptr : &*found;
}

void write_seeds(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    int number = 0;
    for (const auto& seed : target->seeds())
        std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary)
            .write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
    target = target_of((*argv)[0]);
    if (target == nullptr) {
        std::fprintf(stderr, "%s: expected the name of a target behind fuzz_\n", (*argv)[0]);
        std::exit(2);
    }
    if (*argc == 3 && std::strcmp((*argv)[1], "--seeds") == 0) {
        write_seeds((*argv)[2]);
        std::exit(0);
    }
    return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
    std::mt19937 random(seed);
    if (target->damage == nullptr || random() % 2 == 0)
        return LLVMFuzzerMutate(data, size, max_size);
    std::vector<std::uint8_t> bytes(data, data + size);
    target->damage(bytes, random);
    bytes.resize(std::min(bytes.size(), max_size));
    std::ranges::copy(bytes, data);
    return bytes.size();
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        refusal_of(*target, {data, size});
    } catch (const std::exception& find) {
        std::fprintf(stderr, "find: %s\n", find.what());
        std::abort();
    }
    return 0;
}
