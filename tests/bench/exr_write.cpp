/// Writing a 3840x1920 frame (half RGBA and float depth, two parts): ours (OpenEXRCore with libdeflate) against the
/// stock OpenEXR C++ writer at its default ZIP level, and against a copy of the same bytes.
#include "agreement.h"

#include <equistream/sequence.h>
#include <equistream/threads.h>

#include <benchmark/benchmark.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfThreading.h>
#include <half.h>

#include <cmath>
#include <filesystem>
#include <memory>

namespace {

using namespace equistream;

constexpr int width = 3840;
constexpr int height = 1920;

/// A smooth sky above a noisy floor: about as compressible as a rendered frame.
const Frame& test_frame() {
    static const Frame frame = [] {
        Frame f;
        f.info.camera = EquirectCamera{width, height, {}};
        FloatImage colour(width, height, 4, 1.0f);
        FloatImage depth(width, height, 1);
        std::uint32_t state = 1;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                state = state * 1664525u + 1013904223u;
                const float noise = y > height / 2 ? static_cast<float>(state >> 16) / 65536.0f * 0.05f : 0.0f;
                for (int c = 0; c < 3; ++c)
                    colour.pixel(x, y)[c] = 0.5f + 0.3f * std::sin(static_cast<float>(x * (c + 1)) * 0.01f) + noise;
                depth.pixel(x, y)[0] = 3.0f + static_cast<float>(x % 97) * 0.01f + static_cast<float>(y) * 0.002f;
            }
        f.planes["colour"] = std::move(colour);
        f.planes["depth"] = std::move(depth);
        return f;
    }();
    return frame;
}

std::filesystem::path scratch(const char* name) {
    return std::filesystem::temp_directory_path() / name;
}

void ours(benchmark::State& state) {
    const auto file = scratch("equistream_bench_ours.exr");
    for (auto _ : state)
        write_exr(file, test_frame());
    std::filesystem::remove(file);
}

void stock(benchmark::State& state) {
    const Frame& frame = test_frame();
    const FloatImage& colour = frame.planes.at("colour");
    const FloatImage& depth = frame.planes.at("depth");
    const auto file = scratch("equistream_bench_stock.exr");
    Imf::setGlobalThreadCount(static_cast<int>(usable_processors()));
    for (auto _ : state) {
        Imf::Header headers[2] = {Imf::Header(width, height), Imf::Header(width, height)};
        const char* names[2] = {"rgba", "data"};
        for (int part = 0; part < 2; ++part) {
            headers[part].setName(names[part]);
            headers[part].setType(Imf::SCANLINEIMAGE);
            headers[part].compression() = Imf::ZIP_COMPRESSION;
        }
        std::vector<Imath::half> halves(colour.samples().begin(), colour.samples().end());
        Imf::FrameBuffer buffers[2];
        const char* channels[4] = {"R", "G", "B", "A"};
        for (std::size_t c = 0; c < 4; ++c) {
            headers[0].channels().insert(channels[c], Imf::Channel(Imf::HALF));
            buffers[0].insert(channels[c],
                              Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.data() + c), 8, 8 * width));
        }
        headers[1].channels().insert("depth.Z", Imf::Channel(Imf::FLOAT));
        buffers[1].insert(
            "depth.Z",
            Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(depth.samples().data())), 4, 4 * width));
        Imf::MultiPartOutputFile output(file.c_str(), headers, 2);
        for (int part = 0; part < 2; ++part) {
            Imf::OutputPart out(output, part);
            out.setFrameBuffer(buffers[part]);
            out.writePixels(height);
        }
    }
    std::filesystem::remove(file);
}

void copy(benchmark::State& state) {
    bench::copy_bytes(state, std::size_t{width} * height * (4 * 2 + 4));
}

BENCHMARK(ours)->Name("exr_write_3840x1920/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(stock)->Name("exr_write_3840x1920/openexr_zip")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("exr_write_3840x1920/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
