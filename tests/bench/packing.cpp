/// Coded packets out of Matroska and into it again, without coding. The stream has 33 tracks of 24 pictures: a sphere
/// of 1280x640 in 8x4 tiles, and one of 640x320 around them. Unpacking finds when each byte is due, as a server does
/// before it sends a recording. Packing makes the bytes for a viewer that looks everywhere. Both stand against
/// libavformat alone, which reads or copies all packets, and against a copy of the file in memory.
#include "agreement.h"

#include <equistream/error.h>
#include <equistream/send_times.h>
#include <equistream/stream.h>
#include <equistream/tile_stream.h>
#include <equistream/window.h>
#include <plugin/stream/libav.h>

#include <benchmark/benchmark.h>

#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

namespace {

using namespace equistream;

constexpr int sphere_columns = 1280, base_columns = 640, picture_count = 24;
constexpr double pictures_per_second = 30;
constexpr TileGrid tile_counts{8, 4};

/// Grain alone, of which coding leaves large packets.
ByteImage picture(int columns, int index) {
    ByteImage rgb(columns, columns / 2, 3);
    std::uint32_t state = static_cast<std::uint32_t>(index) + 1;
    for (std::uint8_t& sample : rgb.samples()) {
        state = state * 1664525u + 1013904223u;
        sample = static_cast<std::uint8_t>(100 + (state >> 27));
    }
    return rgb;
}

av::Demuxer opened(const std::string& file) {
    AVFormatContext* format = nullptr;
    if (avformat_open_input(&format, file.c_str(), nullptr, nullptr) < 0)
        throw WorkError("libavformat cannot open the stream");
    av::Demuxer demuxer(format);
    avformat_find_stream_info(format, nullptr);
    return demuxer;
}

/// Says how many there were.
template <typename Use>
int each_packet(AVFormatContext& format, const Use& use) {
    const av::Packet packet = av::make_packet();
    int packets = 0;
    for (; av_read_frame(&format, packet.get()) >= 0; ++packets) {
        use(*packet);
        av_packet_unref(packet.get());
    }
    return packets;
}

/// The stream as a file, removed at exit.
class CodedTiles {
public:
    CodedTiles()
        : file_(std::filesystem::temp_directory_path() /
                ("equistream-bench-" + std::to_string(getpid()) + "-tiles.mkv")) {
        const WindowGrid grid = tile_grid(sphere_columns, tile_counts);
        StreamSettings settings;
        settings.preset = "ultrafast";
        settings.frames_per_second = pictures_per_second;
        settings.pictures = picture_count;
        settings.tracks.assign(std::size_t(tile_counts.count()) + 1, {TrackRole::window, grid.width, grid.height});
        settings.tracks.front() = {TrackRole::main, base_columns, base_columns / 2};
        StreamWriter writer(name(), settings);
        for (int i = 0; i < picture_count; ++i) {
            FrameInfo info;
            info.index = i;
            info.time_s = i / pictures_per_second;
            info.camera = EquirectCamera{base_columns, base_columns / 2, {}};
            writer.write(TrackRole::main, picture(base_columns, i).view(), info);
            const ByteImage sphere = picture(sphere_columns, i);
            for (int tile = 0; tile < tile_counts.count(); ++tile) {
                const WindowPlace place = tile_place(grid, tile_counts, tile);
                info.camera = window_camera(grid, place);
                writer.write(TrackRole::window, window_pixels(sphere, grid, place).view(), info, std::size_t(tile));
            }
        }
        writer.finish();
        each_packet(*opened(name()), [this](const AVPacket& packet) { packet_bytes_ += std::size_t(packet.size); });
    }
    ~CodedTiles() { std::filesystem::remove(file_); }
    CodedTiles(const CodedTiles&) = delete;
    CodedTiles& operator=(const CodedTiles&) = delete;

    std::string name() const { return file_.string(); }
    std::size_t bytes() const { return std::filesystem::file_size(file_); }
    std::size_t packet_bytes() const { return packet_bytes_; }

private:
    std::filesystem::path file_;
    std::size_t packet_bytes_ = 0;
};

const CodedTiles& coded() {
    static const CodedTiles coded;
    return coded;
}

void unpack(benchmark::State& state) {
    const std::string file = coded().name();
    for (auto _ : state) {
        const SendTimes times = read_send_times(file);
        if (std::abs(times.duration_s - picture_count / pictures_per_second) > 0.01)
            state.SkipWithError("not every picture has its time");
    }
}

void libavformat_unpack(benchmark::State& state) {
    const std::string file = coded().name();
    for (auto _ : state)
        if (each_packet(*opened(file), [](const AVPacket&) {}) != picture_count * (tile_counts.count() + 1))
            state.SkipWithError("not every packet was read");
}

void expect_all(benchmark::State& state, std::size_t bytes) {
    if (bytes < coded().packet_bytes())
        state.SkipWithError("not every packet was packed");
}

void pack(benchmark::State& state) {
    static const std::optional<TileRecording> recording = open_tiles(coded().name());
    if (!recording)
        return state.SkipWithError("not every track was found");
    std::set<int> everywhere;
    for (int tile = 0; tile < tile_counts.count(); ++tile)
        everywhere.insert(tile);
    for (auto _ : state) {
        TileSender sender(*recording);
        std::string bytes;
        while (sender.due_s())
            sender.next(everywhere, bytes);
        expect_all(state, bytes.size());
    }
}

/// What `ffmpeg -c copy` does where it cannot go back in its output.
std::size_t copied_bytes(AVFormatContext& from) {
    AVFormatContext* made = nullptr;
    if (avformat_alloc_output_context2(&made, nullptr, "matroska", nullptr) < 0)
        throw WorkError("libavformat cannot write Matroska");
    const av::Muxer to(made);
    if (avio_open_dyn_buf(&to->pb) < 0)
        throw WorkError("libavformat has no memory");
    to->pb->seekable = 0;
    bool is_ready = true;
    for (unsigned i = 0; i < from.nb_streams; ++i) {
        AVStream* const stream = avformat_new_stream(to.get(), nullptr);
        is_ready =
            is_ready && stream != nullptr && avcodec_parameters_copy(stream->codecpar, from.streams[i]->codecpar) >= 0;
        if (!is_ready)
            break;
        stream->codecpar->codec_tag = 0;
        stream->time_base = from.streams[i]->time_base;
    }
    if (is_ready && avformat_write_header(to.get(), nullptr) >= 0) {
        each_packet(from, [&](AVPacket& packet) {
            const int index = packet.stream_index;
            av_packet_rescale_ts(&packet, from.streams[index]->time_base, to->streams[index]->time_base);
            packet.pos = -1;
            av_interleaved_write_frame(to.get(), &packet);
        });
        av_write_trailer(to.get());
    }
    std::uint8_t* bytes = nullptr;
    const int count = avio_close_dyn_buf(to->pb, &bytes);
    av_free(bytes);
    return std::size_t(count);
}

void libavformat_pack(benchmark::State& state) {
    const std::string file = coded().name();
    for (auto _ : state)
        expect_all(state, copied_bytes(*opened(file)));
}

void copy_file(benchmark::State& state) {
    bench::copy_bytes(state, coded().bytes());
}

BENCHMARK(unpack)->Name("unpack_33_tracks/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(libavformat_unpack)->Name("unpack_33_tracks/libavformat")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy_file)->Name("unpack_33_tracks/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(pack)->Name("pack_33_tracks/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(libavformat_pack)->Name("pack_33_tracks/libavformat")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy_file)->Name("pack_33_tracks/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
