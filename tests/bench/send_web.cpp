/// The 32 MB of send.cpp as `serve --web` sends them to a browser, by WebSocket, and the connection for it. The browser
/// is played by Boost.Beast's client. The peers are in send.cpp, for no file may include both Asio and Boost.Asio.
#include "byte_server.h"

#include <benchmark/benchmark.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace {

using namespace equistream;
namespace beast = boost::beast;
namespace net = boost::asio;
namespace websocket = beast::websocket;
using net::ip::tcp;

/// How many bytes came before the server ended the stream.
std::size_t receive(std::uint16_t port, std::vector<char>& got) {
    net::io_context io;
    websocket::stream<tcp::socket> socket(io);
    const std::string host = "127.0.0.1:" + std::to_string(port);
    socket.set_option(websocket::stream_base::decorator([&host](websocket::request_type& request) {
        request.set(beast::http::field::origin, "http://" + host);  // as the server's own page asks
    }));
    beast::error_code error;
    socket.next_layer().connect(tcp::endpoint(net::ip::address_v4::loopback(), port), error);
    if (!error)
        socket.handshake(host, "/stream", error);
    std::size_t total = 0;
    while (!error)
        total += socket.read_some(net::buffer(got.data(), got.size()), error);
    return total;
}

void ours(benchmark::State& state) {
    const bench::ByteServer server(Scheme::tcp, true);
    std::vector<char> got(bench::block_bytes);
    for (auto _ : state)
        if (receive(server.web_port(), got) != bench::sent_bytes)
            state.SkipWithError("not everything came");
}

BENCHMARK(ours)->Name("send_web_32MB/ours")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
