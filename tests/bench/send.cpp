/// 32 MB from a server to a client on this machine, and the connection for it: ours by TCP, by TLS and by SRT, against
/// sockets that do nothing else, against FFmpeg's TCP and SRT on both ends, and against a copy in memory.
#include "agreement.h"
#include "byte_server.h"

#include <client/transport/server_connection.h>
#include <plugin/stream/libav.h>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ip/udp.hpp>
#include <asio/write.hpp>
#include <benchmark/benchmark.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace {

using namespace equistream;
using bench::block_bytes;
using bench::sent_bytes;
using bench::what_is_sent;

/// By TCP, TLS or SRT.
void ours(benchmark::State& state, Scheme scheme) {
    const bench::ByteServer server(scheme);
    std::vector<std::uint8_t> got(block_bytes);
    for (auto _ : state) {
        std::size_t total = 0;
        try {
            ServerConnection connection(server.url(), nullptr, {});
            while (const std::size_t count = connection.read(got))
                total += count;
        } catch (const std::exception& error) {
            return state.SkipWithError(("not everything came: " + std::string(error.what())).c_str());
        }
        if (total != sent_bytes)
            state.SkipWithError("not everything came");
    }
}

void sockets(benchmark::State& state) {
    using asio::ip::tcp;
    asio::io_context io;
    tcp::acceptor acceptor(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    std::vector<char> got(block_bytes);
    for (auto _ : state) {
        std::thread serves([&] {
            tcp::socket socket(io);
            acceptor.accept(socket);
            asio::error_code error;
            for (std::size_t at = 0; at < sent_bytes; at += block_bytes)
                asio::write(socket, asio::buffer(what_is_sent().data() + at, block_bytes), error);
        });
        tcp::socket socket(io);
        socket.connect(acceptor.local_endpoint());
        asio::error_code error;
        std::size_t total = 0;
        while (const std::size_t count = socket.read_some(asio::buffer(got), error))
            total += count;
        serves.join();
        if (total != sent_bytes)
            state.SkipWithError("not everything came");
    }
}

/// Of a context that FFmpeg opens.
struct IoCloser {
    void operator()(AVIOContext* io) const { avio_closep(&io); }
};
using OpenIo = std::unique_ptr<AVIOContext, IoCloser>;

OpenIo opened(const std::string& url, int flags) {
    AVIOContext* io = nullptr;
    return OpenIo(avio_open(&io, url.c_str(), flags) < 0 ? nullptr : io);
}

/// That nobody has.
template <typename Protocol>
std::string free_port() {
    asio::io_context io;
    const typename Protocol::socket socket(io, typename Protocol::endpoint(asio::ip::address_v4::loopback(), 0));
    return std::to_string(socket.local_endpoint().port());
}

void ffmpeg_tcp(benchmark::State& state) {
    const std::string url = "tcp://127.0.0.1:" + free_port<asio::ip::tcp>();
    av_log_set_level(AV_LOG_QUIET);
    std::vector<unsigned char> got(block_bytes);
    for (auto _ : state) {
        std::thread serves([&] {
            if (const OpenIo io = opened(url + "?listen=1", AVIO_FLAG_WRITE))
                avio_write(io.get(), reinterpret_cast<const unsigned char*>(what_is_sent().data()), int(sent_bytes));
        });
        OpenIo io;
        while (!(io = opened(url, AVIO_FLAG_READ)))  // until it listens
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        std::size_t total = 0;
        for (int count = 0; (count = avio_read_partial(io.get(), got.data(), int(got.size()))) > 0;)
            total += std::size_t(count);
        serves.join();
        if (total != sent_bytes)
            state.SkipWithError("not everything came");
    }
}

bool ffmpeg_writes(std::string_view protocol) {
    void* at = nullptr;
    while (const char* const known = avio_enum_protocols(&at, 1))
        if (known == protocol)
            return true;
    return false;
}

/// Encrypted too, in the mode that FFmpeg sends streams in, but without that mode's delay, limit of speed and dropping
/// of late packets. The connection is not counted: where libsrt asks before the other end listens, it asks again only a
/// quarter of a second later.
void ffmpeg_srt(benchmark::State& state) {
    if (!ffmpeg_writes("srt"))
        return state.SkipWithError("srt is not in this FFmpeg");
    const std::string options = "latency=0&tlpktdrop=0&maxbw=1250000000&passphrase=" + std::string(bench::secret);
    av_log_set_level(AV_LOG_QUIET);
    std::vector<unsigned char> got(block_bytes);
    for (auto _ : state) {
        state.PauseTiming();
        const std::string url = "srt://127.0.0.1:" + free_port<asio::ip::udp>() + "?";
        std::promise<void> begins, has_all;
        std::atomic<bool> has_failed = false;
        std::thread serves([&] {
            const OpenIo io = opened(url + "mode=listener&" + options, AVIO_FLAG_WRITE);
            has_failed = io == nullptr;
            begins.get_future().wait();
            if (io == nullptr)
                return;
            avio_write(io.get(), reinterpret_cast<const unsigned char*>(what_is_sent().data()), int(sent_bytes));
            avio_flush(io.get());
            has_all.get_future().wait();  // closing drops what has not arrived
        });
        OpenIo io;
        while (io == nullptr && !has_failed)
            io = opened(url + options, AVIO_FLAG_READ);
        state.ResumeTiming();
        begins.set_value();
        std::size_t total = 0;
        while (io != nullptr && total < sent_bytes) {
            const int count = avio_read_partial(io.get(), got.data(), int(got.size()));
            if (count <= 0)
                break;
            total += std::size_t(count);
        }
        state.PauseTiming();
        has_all.set_value();
        io.reset();
        serves.join();
        state.ResumeTiming();
        if (total != sent_bytes)
            return state.SkipWithError("not everything came");
    }
}

void copy(benchmark::State& state) {
    bench::copy_bytes(state, sent_bytes);
}

BENCHMARK_CAPTURE(ours, tcp, Scheme::tcp)->Name("send_32MB/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ours, tls, Scheme::tls)->Name("send_tls_32MB/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ours, srt, Scheme::srt)->Name("send_srt_32MB/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(sockets)->Name("send_32MB/sockets")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(sockets)->Name("send_web_32MB/sockets")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(ffmpeg_tcp)->Name("send_32MB/ffmpeg")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(ffmpeg_srt)->Name("send_srt_32MB/ffmpeg")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("send_32MB/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("send_tls_32MB/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("send_srt_32MB/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("send_web_32MB/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
