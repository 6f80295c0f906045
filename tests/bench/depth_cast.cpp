/// Depth along the pixel-centre rays of a 1920x960 sphere: the client's `ray` source against Embree's own
/// rtcIntersect16 with coherent rays, on both the same geometry and the same without its alpha masks. All sides take
/// the same squares of 4x4 rays and share them out alike; the peer's packets are made, and made anew after each round,
/// outside the time that counts.
#include "bench_scene.h"

#include <equistream/elapsed.h>
#include <scenes/embree/embree_rays.h>

#include <benchmark/benchmark.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>
#include <vector>

namespace {

using namespace equistream;
using bench::BenchScene;

constexpr int width = 1920, height = 960, packet_side = 4;
constexpr std::size_t packet_count = std::size_t{width / packet_side} * (height / packet_side);

BenchScene* scene_or_skip(benchmark::State& state, const char* name) {
    BenchScene* scene = bench::bench_scene(name);
    if (scene == nullptr)
        state.SkipWithError("EQUISTREAM_SCENES is not set");
    return scene;
}

/// A world-locked sphere's, where the path begins.
Pose pose_in(const BenchScene& scene) {
    return {scene.description.camera_path.at(0).position_m, {1, 0, 0, 0}};
}

std::vector<RayPacket> packets_of(const Pose& pose) {
    const EquirectCamera camera{width, height, {}};
    std::vector<RayPacket> packets(packet_count);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int packet = y / packet_side * (width / packet_side) + x / packet_side;
            const int lane = y % packet_side * packet_side + x % packet_side;
            packets[static_cast<std::size_t>(packet)].start(
                static_cast<std::size_t>(lane), glm::vec3(pose.position_m),
                glm::vec3(pose.orientation * camera.direction(x + 0.5, y + 0.5)));
        }
    return packets;
}

void intersect_coherent(RTCScene scene, RayPacket& packet) {
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(packet.valid.data(), scene, &packet.rays, &arguments);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(packet.valid.data(), scene, &context, &packet.rays);
#endif
}

double intersect_all(RTCScene scene, std::vector<RayPacket>& packets) {
    const auto start = Clock::now();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, packets.size(), 32), [&](const auto& range) {
        trace_thread_init();
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            intersect_coherent(scene, packets[i]);
    });
    return milliseconds_since(start);
}

void ours(benchmark::State& state, const char* name) {
    BenchScene* scene = scene_or_skip(state, name);
    if (scene == nullptr)
        return;
    FloatImage depth_m(width, height, 1);
    for (auto _ : state) {
        const auto start = Clock::now();
        scene->depth.cast(EquirectCamera{width, height, {}}, pose_in(*scene), depth_m.view());
        state.SetIterationTime(milliseconds_since(start) / 1000);
    }
    benchmark::DoNotOptimize(depth_m.samples().data());
}

void embree(benchmark::State& state, const char* name, Bvh BenchScene::*geometry) {
    const BenchScene* scene = scene_or_skip(state, name);
    if (scene == nullptr)
        return;
    const std::vector<RayPacket> made = packets_of(pose_in(*scene));
    std::vector<RayPacket> packets;
    const RTCScene traced = (scene->*geometry).scene();
    for (auto _ : state) {
        packets = made;
        state.SetIterationTime(intersect_all(traced, packets) / 1000);
    }
    benchmark::DoNotOptimize(packets.data());
}

template <typename... Arguments>
void add(const std::string& name, Arguments... arguments) {
    benchmark::RegisterBenchmark(name.c_str(), arguments...)->UseManualTime()->Unit(benchmark::kMillisecond);
}

[[maybe_unused]] const bool added = [] {
    for (const char* scene : {"pavilion", "sponza-crytek"}) {
        const std::string figure = std::string("depth_cast_") + scene;
        add(figure + "/ours", ours, scene);
        add(figure + "/rtcIntersect16", embree, scene, &BenchScene::bvh);
        add(figure + "/rtcIntersect16_unmasked", embree, scene, &BenchScene::bvh_without_masks);
    }
    return true;
}();

}  // namespace
