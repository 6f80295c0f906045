/// The noise of a path traced sphere taken out on whatever device Open Image Denoise finds (OIDN_DEFAULT_DEVICE picks
/// another): `ours` wraps it at the seam and over the poles, sets its exposure and brings it there and back. Against
/// the library's filter by itself on a picture that is there already, and against a copy of the pictures' bytes.
#include "agreement.h"

#include <equistream/error.h>
#include <plugin/denoise/denoiser.h>
#include <plugin/denoise/oidn.h>

#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace equistream;

constexpr std::array<const char*, 3> planes = {"colour", "guide_albedo", "guide_normal"};
constexpr std::array<const char*, 3> filter_images = {"color", "albedo", "normal"};

FloatImage noise(int width, int height, int channels) {
    FloatImage picture(width, height, channels);
    std::minstd_rand random(1);
    for (float& sample : picture.samples())
        sample = float(random() >> 8) / float(1 << 23);
    return picture;
}

Frame noisy_sphere(int columns) {
    Frame frame;
    frame.info.camera = EquirectCamera{columns, columns / 2, {}};
    for (const char* plane : planes)
        frame.planes[plane] = noise(columns, columns / 2, plane == planes[0] ? 4 : 3);
    return frame;
}

void ours(benchmark::State& state, int columns, DenoiseQuality quality) {
    try {
        Denoiser denoiser(quality, 0);
        Frame frame = noisy_sphere(columns);
        denoiser.denoise(frame);
        for (auto _ : state)
            denoiser.denoise(frame);
        state.SetLabel(denoiser.description());
    } catch (const InputError& error) {
        state.SkipWithError(error.what());
    }
}

void library(benchmark::State& state, int columns, DenoiseQuality quality) {
    try {
        const std::shared_ptr<const oidn::Device> device = oidn::shared_device(0);
        const oidn::Library& library = device->functions();
        const std::size_t width = std::size_t(columns), height = width / 2, pixel = 3 * sizeof(float);
        const FloatImage picture = noise(columns, columns / 2, 3);
        const std::unique_ptr<void, void (*)(oidn::Handle)> filter(library.new_filter(device->handle(), "RT"),
                                                                   library.release_filter);
        std::vector<std::unique_ptr<void, void (*)(oidn::Handle)>> buffers;
        for (const char* image : filter_images) {
            buffers.emplace_back(library.new_buffer(device->handle(), width * height * pixel), library.release_buffer);
            library.write_buffer(buffers.back().get(), 0, width * height * pixel, picture.samples().data());
            library.set_filter_image(filter.get(), image, buffers.back().get(), oidn::float3, width, height, 0, 0, 0);
        }
        library.set_filter_image(filter.get(), "output", buffers.front().get(), oidn::float3, width, height, 0, 0, 0);
        library.set_filter_bool(filter.get(), "hdr", true);
        library.set_filter_bool(filter.get(), "cleanAux", true);
        library.set_filter_float(filter.get(), "inputScale", 1);
        library.set_filter_int(filter.get(), "quality", quality == DenoiseQuality::fast ? oidn::fast : oidn::balanced);
        library.commit_filter(filter.get());
        library.execute_filter(filter.get());
        for (auto _ : state)
            library.execute_filter(filter.get());
        device->check("denoise");
    } catch (const InputError& error) {
        state.SkipWithError(error.what());
    }
}

void copy(benchmark::State& state, int columns) {
    bench::copy_bytes(state, std::size_t(columns) * std::size_t(columns) / 2 * sizeof(float) * 10);
}

[[maybe_unused]] const bool added = [] {
    const auto add = [](const std::string& name, auto... arguments) {
        benchmark::RegisterBenchmark(name.c_str(), arguments...)->UseRealTime()->Unit(benchmark::kMillisecond);
    };
    for (const int columns : {1920, 3840})
        for (const auto& [name, quality] :
             {std::pair("fast", DenoiseQuality::fast), {"balanced", DenoiseQuality::balanced}}) {
            const std::string figure = "denoise_" + std::to_string(columns) + "_" + name;
            add(figure + "/ours", ours, columns, quality);
            add(figure + "/library", library, columns, quality);
            add(figure + "/memcpy", copy, columns);
        }
    return true;
}();

}  // namespace
