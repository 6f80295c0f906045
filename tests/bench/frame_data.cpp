/// The frame data that every picture carries (docs/stream-format.md), to bytes and back: of 1,000 pictures of main,
/// against a copy of the same bytes.
#include "agreement.h"

#include <equistream/stream.h>
#include <equistream/visible_loss.h>

#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

namespace {

using namespace equistream;

constexpr std::uint32_t frame_count = 1000;

FrameInfo frame_info(std::uint32_t index) {
    FrameInfo info;
    info.index = index;
    info.time_s = index / info.frames_per_second;
    info.camera = EquirectCamera{3840, 1920, {}};
    info.head_radius_m = 0.1;
    info.scene = "pavilion";
    info.host = "Embree 4.3.3";
    info.geometry_fingerprint = "0123456789abcdef";
    info.crf = 16.0f;
    info.visible_loss = usual_coding_loss(16);
    return info;
}

std::vector<std::uint8_t> frame_data(const FrameInfo& info) {
    return encode_frame_info(TrackRole::main, info, {std::uint32_t(info.index), frame_count});
}

/// Of all frames together.
std::size_t frame_data_bytes() {
    return frame_count * frame_data(frame_info(0)).size();
}

void pack_frame_data(benchmark::State& state) {
    std::vector<FrameInfo> frames;
    for (std::uint32_t i = 0; i < frame_count; ++i)
        frames.push_back(frame_info(i));
    const std::size_t expected = frame_data_bytes();
    for (auto _ : state) {
        std::size_t bytes = 0;
        for (const FrameInfo& info : frames)
            bytes += frame_data(info).size();
        if (bytes != expected)
            state.SkipWithError("not every frame was packed");
    }
}

void unpack_frame_data(benchmark::State& state) {
    std::vector<std::vector<std::uint8_t>> frames;
    for (std::uint32_t i = 0; i < frame_count; ++i)
        frames.push_back(frame_data(frame_info(i)));
    for (auto _ : state) {
        std::uint32_t next = 0;
        for (const auto& bytes : frames)
            if (const auto tagged = decode_frame_info(bytes); tagged && tagged->info.index == next)
                ++next;
        if (next != frame_count)
            state.SkipWithError("not every frame came back");
    }
}

void copy_frame_data(benchmark::State& state) {
    bench::copy_bytes(state, frame_data_bytes());
}

BENCHMARK(pack_frame_data)->Name("pack_frame_data_1000/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy_frame_data)->Name("pack_frame_data_1000/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(unpack_frame_data)->Name("unpack_frame_data_1000/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy_frame_data)->Name("unpack_frame_data_1000/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
