#pragma once
/// The machine's own limit as a peer: a copy of the same bytes.
#include <benchmark/benchmark.h>

#include <cstring>
#include <vector>

namespace equistream::bench {

inline void copy_bytes(benchmark::State& state, std::size_t bytes) {
    std::vector<char> from(bytes, 1), to(bytes);
    for (auto _ : state) {
        std::memcpy(to.data(), from.data(), bytes);
        benchmark::ClobberMemory();
    }
}

}  // namespace equistream::bench
