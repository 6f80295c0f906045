/// Sixteen colour samples a pixel handed to the film of a 960x480 sphere through the C ABI, tile by tile, by one
/// thread: against copies of the same samples to the same places.
#include <equistream/equistream.h>

#include <benchmark/benchmark.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

namespace {

constexpr int width = 960, height = 480;
constexpr std::uint32_t samples_per_pixel = 16;

/// A sequence in a folder of its own; no frame of it is ever written.
class Sequence {
public:
    Sequence()
        : folder_(std::filesystem::temp_directory_path() / ("equistream-bench-film-" + std::to_string(getpid()))) {
        const std::string folder = folder_.string();
        es_sequence_settings settings{};
        settings.struct_size = sizeof settings;
        settings.abi_version = ES_ABI_VERSION;
        settings.spp = samples_per_pixel;
        settings.width = width;
        settings.height = height;
        settings.frames_per_second = 30;
        settings.exposure = 1;
        settings.output_dir = folder.c_str();
        settings.aovs = "none";
        settings.scene_name = "bench";
        settings.host_name = "bench";
        settings.ipd_m = 0.063;
        es_error error;
        if (es_sequence_open(&settings, &sequence_, &error) != ES_OK)
            throw std::runtime_error(error.text);
    }
    ~Sequence() {
        es_sequence_close(sequence_);
        std::filesystem::remove_all(folder_);
    }
    Sequence(const Sequence&) = delete;
    Sequence& operator=(const Sequence&) = delete;

    es_frame* begin() {
        const es_pose head{{0, 0, 0}, {1, 0, 0, 0}};
        es_frame_settings settings{};
        settings.struct_size = sizeof settings;
        settings.head_previous = settings.head = settings.head_next = head;
        es_frame* frame = nullptr;
        es_frame_begin(sequence_, &settings, &frame, nullptr);
        return frame;
    }

private:
    std::filesystem::path folder_;
    es_sequence* sequence_ = nullptr;
};

void ours(benchmark::State& state) {
    Sequence sequence;
    const std::vector<float> rgba(std::size_t{width} * height * 4, 0.5f);
    for (auto _ : state) {
        es_frame* frame = sequence.begin();
        es_tile tile;
        int tiles = 0;
        for (; es_frame_next_tile(frame, &tile) == ES_OK; ++tiles)
            for (std::uint32_t sample = 0; sample < tile.sample_count; ++sample)
                es_tile_put_radiance(frame, &tile, rgba.data());
        es_frame_discard(frame);
        if (tiles == 0)
            state.SkipWithError("the plugin gave no tiles");
    }
}

void copy(benchmark::State& state) {
    constexpr int side = 32;
    const std::vector<float> rgba(std::size_t{side} * side * 4, 0.5f);
    std::vector<float> film(std::size_t{width} * height * 4);
    constexpr std::size_t row_bytes = std::size_t{side} * 4 * sizeof(float);
    for (auto _ : state)
        for (int tile = 0; tile < width / side * (height / side); ++tile)
            for (std::uint32_t sample = 0; sample < samples_per_pixel; ++sample) {
                const int x = tile % (width / side) * side, y = tile / (width / side) * side;
                for (int row = 0; row < side; ++row)
                    std::memcpy(film.data() + (std::size_t(y + row) * width + std::size_t(x)) * 4,
                                rgba.data() + std::size_t(row) * side * 4, row_bytes);
                benchmark::ClobberMemory();
            }
}

BENCHMARK(ours)->Name("film_960x480_16spp/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("film_960x480_16spp/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
