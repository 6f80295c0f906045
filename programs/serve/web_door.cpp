#include "web_door.h"

#include "counted_address.h"
#include "web_connections.h"

#include <client/transport/congestion.h>
#include <client/transport/received_rate.h>
#include <equistream/error.h>

#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <exception>
#include <fstream>
#include <future>
#include <iterator>
#include <thread>

namespace equistream::serve {

namespace {

/// Of one message that a viewer sends (docs/stream-format.md, "From the viewer"): a head, and room for what is
/// appended.
constexpr std::size_t max_message_bytes = 4096 + 12;
/// No more may ask in a second: each costs the processor something. Who is closed at once costs little.
constexpr std::chrono::milliseconds between_connections{10};
constexpr std::chrono::seconds last_words{2};
/// Of a stream, on its way from the server to this door.
constexpr int waiting_bytes = 1 << 14;

}  // namespace

struct WebDoor::Parts {
    WebSettings settings;
    Welcome welcome;
    Crowd asking;  // handlers that go with `io` use it
    net::io_context io{1};
    tcp::acceptor acceptor{io};
    net::steady_timer pause{io};
    bool this_machine_alone = true;
    std::thread thread;
    std::promise<void> has_ended;
    std::optional<net::ssl::context> tls;  // nothing: http://

    Parts(WebSettings what, Welcome how) : settings(std::move(what)), welcome(std::move(how)) {}

    std::chrono::milliseconds patience() const { return std::chrono::milliseconds(int(1000 * settings.patience_s)); }
    void listen();
    void accept();
    template <typename Stream>
    void hear(Stream stream, const tcp::endpoint& peer, const net::ip::address& from);
    template <typename Stream>
    void let_in(websocket::stream<Stream> browser, http::request<http::empty_body> request, Crowd::Place place,
                const tcp::endpoint& peer);
};

namespace {

net::ssl::context tls_context(const std::string& pem) {
    net::ssl::context context(net::ssl::context::tls_server);
    SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_2_VERSION);
    context.use_private_key(net::buffer(pem), net::ssl::context::pem);
    context.use_certificate_chain(net::buffer(pem));
    return context;
}

}  // namespace

Descriptor::~Descriptor() {
    if (number_ >= 0)
        close(number_);
}

void WebDoor::Parts::listen() {
    const tcp::endpoint endpoint(net::ip::make_address(settings.address), settings.port);
    this_machine_alone = endpoint.address().is_loopback();
    Error error;
    acceptor.open(endpoint.protocol(), error);
    if (!error)
        acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error)
        acceptor.bind(endpoint, error);
    if (!error)
        acceptor.listen(net::socket_base::max_listen_connections, error);
    if (error)
        throw InputError(expected_found("--web " + std::to_string(settings.port), "a free address of this machine",
                                        error.message()));
}

void WebDoor::Parts::accept() {
    acceptor.async_accept([this](Error error, tcp::socket socket) {
        if (!acceptor.is_open())
            return;
        Error gone;
        const tcp::endpoint peer = error ? tcp::endpoint() : socket.remote_endpoint(gone);
        const net::ip::address from = counted_address(peer.address());
        const bool may_ask = !error && !gone && asking.has_room_for(from);
        pause.expires_after(may_ask || error ? between_connections : std::chrono::milliseconds(0));
        pause.async_wait([this](Error cancelled) {
            if (!cancelled)
                accept();
        });
        if (!may_ask)
            return;
        socket.set_option(tcp::no_delay(true), gone);
        keep_little_unsent(socket.native_handle());
        use_bbr(socket.native_handle());
        if (tls)
            hear(TlsStream(PlainStream(std::move(socket)), *tls), peer, from);
        else
            hear(PlainStream(std::move(socket)), peer, from);
    });
}

template <typename Stream>
void WebDoor::Parts::hear(Stream stream, const tcp::endpoint& peer, const net::ip::address& from) {
    const auto upgrade = [this, peer](websocket::stream<Stream> browser, http::request<http::empty_body> request,
                                      Crowd::Place place) {
        let_in(std::move(browser), std::move(request), std::move(place), peer);
    };
    std::make_shared<Asking<Stream>>(std::move(stream), settings, this_machine_alone, from, asking, upgrade)->begin();
}

template <typename Stream>
void WebDoor::Parts::let_in(websocket::stream<Stream> browser, http::request<http::empty_body> request,
                            Crowd::Place place, const tcp::endpoint& peer) {
    // Pings are answered by whoever reads.
    browser.set_option(websocket::stream_base::timeout{patience(), patience(), true});
    browser.read_message_max(max_message_bytes);
    // The server never hears of pongs and of messages without bytes.
    beast::get_lowest_layer(browser).rate_policy().read_limit(std::size_t(received_bytes_per_second));
    const auto opening = std::make_shared<websocket::stream<Stream>>(std::move(browser));
    const auto asked = std::make_shared<http::request<http::empty_body>>(std::move(request));
    opening->async_accept(*asked, [this, opening, asked, peer, place = std::move(place)](Error failed) mutable {
        std::array<int, 2> ends{};
        if (failed || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
            return;
        setsockopt(ends[1], SOL_SOCKET, SO_SNDBUF, &waiting_bytes, sizeof waiting_bytes);
        Descriptor own_end(ends[0]), server_end(ends[1]);
        net::local::stream_protocol::socket own(io);
        Error error;
        own.assign(net::local::stream_protocol(), own_end.number(), error);
        if (error)
            return;
        own_end.release();
        std::make_shared<Bridge<Stream>>(std::move(*opening), std::move(own), std::move(place), patience())->start();
        welcome(std::move(server_end), peer.address().to_string(), peer.port());
    });
}

WebDoor::WebDoor(WebSettings settings, Welcome welcome)
    : parts_(std::make_unique<Parts>(std::move(settings), std::move(welcome))) {
    if (!parts_->settings.certificate_pem.empty())
        parts_->tls = tls_context(parts_->settings.certificate_pem);
    parts_->listen();
    const tcp::endpoint at = parts_->acceptor.local_endpoint();
    const std::string host = at.address().is_unspecified() ? net::ip::host_name() : at.address().to_string();
    const bool has_brackets = at.address().is_v6() && !at.address().is_unspecified();
    url_ = (parts_->tls ? "https://" : "http://") + (has_brackets ? "[" + host + "]" : host) + ":" +
           std::to_string(at.port()) + "/";
}

namespace {

/// An exception, of memory for example, ends the connection whose handler throws it. The others go on.
void run(net::io_context& io) {
    for (;;) {
        try {
            io.run();
            return;
        } catch (const std::exception&) {
        }
    }
}

}  // namespace

void WebDoor::start() {
    parts_->accept();
    parts_->thread = std::thread([parts = parts_.get()] {
        run(parts->io);
        parts->has_ended.set_value();
    });
}

void WebDoor::stop_accepting() {
    net::post(parts_->io, [parts = parts_.get()] {
        Error ignored;
        parts->acceptor.close(ignored);
        parts->pause.cancel();
    });
}

WebDoor::~WebDoor() {
    if (!parts_->thread.joinable())
        return;
    stop_accepting();
    if (parts_->has_ended.get_future().wait_for(last_words) != std::future_status::ready)
        parts_->io.stop();
    parts_->thread.join();
}

std::string read_web_page(const std::filesystem::path& program_folder) {
    const auto file = program_folder.parent_path() / "share" / "equistream" / "web.html";
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw InputError(expected_found("--web", "the page " + file.string(), "none (build equistream_web_page)"));
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace equistream::serve
