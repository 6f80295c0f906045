/// Depth of a 3840x1920 sphere to a code's samples and back, against a copy of the same bytes: what is read and what is
/// written, half each.
#include <equistream/depth_code.h>

#include <benchmark/benchmark.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace {

using namespace equistream;

constexpr int width = 3840, height = 1920;
constexpr int threads = 2;
constexpr DepthRange range{0.0315, 0.3, false};

/// A floor, walls and a sky.
FloatImage some_depth() {
    FloatImage depth_m(width, height, 1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            depth_m.pixel(x, y)[0] = y < height / 4 ? HUGE_VALF : 0.3f + float((x * 7 + y * 13) % 4096) * 0.01f;
    return depth_m;
}

std::size_t bytes_of(const PlaneFormat& format) {
    std::size_t samples = 0;
    for (int i = 0; i < format.plane_count(); ++i)
        samples += std::size_t(width / format.step(i)) * std::size_t(height / format.step(i));
    return samples * (format.bits == 8 ? 1 : 2);
}

void pack(benchmark::State& state, const char* name) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto code = make_depth_code(name);
    const FloatImage depth_m = some_depth();
    Planes planes(code->format(), width, height);
    for (auto _ : state) {
        code->pack(depth_m.view(), range, planes.view());
        benchmark::ClobberMemory();
    }
}

void unpack(benchmark::State& state, const char* name) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto code = make_depth_code(name);
    FloatImage depth_m = some_depth();
    Planes planes(code->format(), width, height);
    code->pack(depth_m.view(), range, planes.view());
    for (auto _ : state) {
        code->unpack(planes.view(), range, depth_m.view());
        benchmark::ClobberMemory();
    }
}

void copy(benchmark::State& state, const char* name) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const std::size_t bytes =
        (std::size_t(width) * height * sizeof(float) + bytes_of(make_depth_code(name)->format())) / 2;
    std::vector<char> from(bytes, 1), to(bytes);
    for (auto _ : state) {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bytes, 1 << 18), [&](const auto& part) {
            std::memcpy(to.data() + part.begin(), from.data() + part.begin(), part.size());
        });
        benchmark::ClobberMemory();
    }
}

void in_milliseconds(benchmark::internal::Benchmark* benchmark) {
    benchmark->UseRealTime()->Unit(benchmark::kMillisecond);
}

[[maybe_unused]] const bool registered = [] {
    for (const char* name : {"w8", "w10", "w12", "pece444", "pece420", "hue", "lossless"}) {
        const std::string figure = std::string("_") + name;
        in_milliseconds(benchmark::RegisterBenchmark(("depth_pack" + figure + "/ours").c_str(), pack, name));
        in_milliseconds(benchmark::RegisterBenchmark(("depth_pack" + figure + "/memcpy").c_str(), copy, name));
        in_milliseconds(benchmark::RegisterBenchmark(("depth_unpack" + figure + "/ours").c_str(), unpack, name));
        in_milliseconds(benchmark::RegisterBenchmark(("depth_unpack" + figure + "/memcpy").c_str(), copy, name));
    }
    return true;
}();

}  // namespace
