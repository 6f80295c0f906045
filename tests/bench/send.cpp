/// 32 MB from a server to a client on this machine, and the connection for it: ours by TCP and by TLS, against sockets
/// that do nothing else, against FFmpeg's TCP on both ends, and against a copy in memory.
#include "agreement.h"

#include <client/transport/secret.h>
#include <client/transport/server_connection.h>
#include <equistream/error.h>
#include <plugin/stream/libav.h>
#include <programs/serve/server.h>

#include <asio/io_context.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace equistream;

constexpr std::size_t sent_bytes = 32 << 20;
/// As a viewer's blocks are.
constexpr std::size_t block_bytes = 1 << 16;
constexpr const char* secret = "a-secret-of-this-benchmark";

const std::vector<char>& what_is_sent() {
    static const std::vector<char> bytes(sent_bytes, 'x');
    return bytes;
}

/// All at once, as fast as a viewer takes it.
class Everything : public serve::Programme {
public:
    std::unique_ptr<serve::Feed> open_feed() override { return std::make_unique<Feed>(); }

private:
    class Feed : public serve::Feed {
    public:
        serve::Portion next(std::span<char> block, double elapsed_s) override {
            const std::size_t count = std::min(block.size(), sent_bytes - given_);
            std::memcpy(block.data(), what_is_sent().data() + given_, count);
            given_ += count;
            return {.bytes = count, .due_s = elapsed_s, .ended = count == 0};
        }

    private:
        std::size_t given_ = 0;
    };
};

void ours(benchmark::State& state, const char* scheme) {
    asio::io_context io;
    Everything everything;
    const auto address = parse_server_address(std::string(scheme) + "://127.0.0.1:0");
    auto door = serve::bind_door(io, *address, secret, 10, "bench");
    serve::ServerSettings settings;
    settings.log = cli::ProgressStyle::none;
    door->listen("bench");
    const std::string url = std::string(scheme) + "://" +
                            (address->scheme == Scheme::tls ? std::string(secret) + "@" : "") +
                            "127.0.0.1:" + std::to_string(door->address().port);
    serve::Server server(io, std::move(door), everything, settings);
    server.start();
    std::thread serves([&] { io.run(); });
    std::vector<std::uint8_t> got(block_bytes);
    for (auto _ : state) {
        ServerConnection connection(url, nullptr, {});
        std::size_t total = 0;
        while (const std::size_t count = connection.read(got))
            total += count;
        if (total != sent_bytes)
            state.SkipWithError("not everything came");
    }
    asio::post(io, [&] { server.stop(); });
    serves.join();
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
std::string free_port() {
    asio::io_context io;
    const asio::ip::tcp::acceptor acceptor(io, asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    return std::to_string(acceptor.local_endpoint().port());
}

void ffmpeg(benchmark::State& state) {
    const std::string url = "tcp://127.0.0.1:" + free_port();
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

void copy(benchmark::State& state) {
    bench::copy_bytes(state, sent_bytes);
}

BENCHMARK_CAPTURE(ours, tcp, "tcp")->Name("send_32MB/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ours, tls, "tls")->Name("send_tls_32MB/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(sockets)->Name("send_32MB/sockets")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(ffmpeg)->Name("send_32MB/ffmpeg")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("send_32MB/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("send_tls_32MB/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
