/// libFuzzer's entry for one target, which the build names. `--seeds FOLDER` writes the target's seeds and ends.
#include "target.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

using namespace equistream::fuzz;

namespace {

void write_seeds(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    int number = 0;
    for (const auto& seed : FUZZ_TARGET.seeds())
        std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary)
            .write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
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
    if (FUZZ_TARGET.damage == nullptr || random() % 2 == 0)
        return LLVMFuzzerMutate(data, size, max_size);
    FUZZ_TARGET.damage({data, size}, random);
    return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        refusal_of(FUZZ_TARGET, {data, size});
    } catch (const std::exception& find) {
        std::fprintf(stderr, "find: %s\n", find.what());
        std::abort();
    }
    return 0;
}
