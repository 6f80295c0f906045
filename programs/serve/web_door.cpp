#include "web_door.h"

#include <equistream/error.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

namespace equistream::serve {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
namespace net = boost::asio;
using net::ip::tcp;
using Error = boost::system::error_code;

/// Of one message that a viewer sends (docs/stream-format.md, "From the viewer"): a head, and room for what is
/// appended.
constexpr std::size_t largest_message = 4096 + 12;
constexpr std::size_t largest_header = 8192;
/// Connections that have not become viewers, of all and of one address but for this machine's: more are closed at once.
constexpr int most_asking = 64, most_asking_from_one = 16;
/// No more come in a second: each costs the processor something.
constexpr std::chrono::milliseconds between_connections{10};
constexpr std::chrono::seconds last_words{2};

/// The name without its port: "127.0.0.1:80" or "[::1]:80".
std::string_view name_of(std::string_view host) {
    const auto end = host.starts_with('[') ? host.find(']') : host.rfind(':');
    return host.substr(0, end == std::string_view::npos ? end : end + (host.starts_with('[') ? 1 : 0));
}

/// Where only this machine is listened to, nobody may come here by another name. Else a stranger's name that leads here
/// would let the stranger's pages in.
bool is_own_name(std::string_view host) {
    const std::string_view name = name_of(host);
    return name == "localhost" || name == "127.0.0.1" || name == "[::1]";
}

/// Whether a page from this server asks.
bool is_own_page(std::string_view origin, std::string_view host) {
    return origin == "http://" + std::string(host) || origin == "https://" + std::string(host);
}

/// Between a WebSocket and one end of a pair of local sockets, both ways. What is not read on one side is not read on
/// the other: the server's viewer keeps to its limits.
class Bridge : public std::enable_shared_from_this<Bridge> {
public:
    Bridge(websocket::stream<beast::tcp_stream> browser, net::local::stream_protocol::socket server)
        : browser_(std::move(browser)), server_(std::move(server)) {}

    void start() {
        browser_.binary(true);
        send();
        hear();
    }

private:
    void send() {
        server_.async_read_some(net::buffer(block_), [self = shared_from_this()](Error error, std::size_t count) {
            if (error)
                return self->end();
            self->has_sent_ = true;
            self->browser_.async_write(net::buffer(self->block_, count), [self](Error failed, std::size_t) {
                if (failed)
                    return self->hang_up();
                self->send();
            });
        });
    }

    /// The server has said all.
    void end() {
        const websocket::close_reason reason =
            has_sent_ ? websocket::close_reason(websocket::close_code::normal)
                      : websocket::close_reason(websocket::close_code::try_again_later, "no room for another viewer");
        browser_.async_close(reason, [self = shared_from_this()](Error) { self->hang_up(); });
    }

    void hear() {
        browser_.async_read(heard_, [self = shared_from_this()](Error error, std::size_t) {
            if (error)
                return self->hang_up();
            net::async_write(self->server_, self->heard_.data(), [self](Error failed, std::size_t) {
                if (failed)
                    return;  // it is ending
                self->heard_.consume(self->heard_.size());
                self->hear();
            });
        });
    }

    void hang_up() {
        Error ignored;
        server_.close(ignored);
        beast::get_lowest_layer(browser_).close();
    }

    websocket::stream<beast::tcp_stream> browser_;
    net::local::stream_protocol::socket server_;
    std::array<char, 1 << 16> block_;
    beast::flat_buffer heard_;
    bool has_sent_ = false;
};

/// Who has connected and is no viewer yet.
class Crowd {
public:
    bool has_room_for(const net::ip::address& from) const {
        const auto same = from_.find(from);
        return all_ < most_asking && (from.is_loopback() || same == from_.end() || same->second < most_asking_from_one);
    }
    void add(const net::ip::address& from) {
        ++from_[from];
        ++all_;
    }
    void remove(const net::ip::address& from) {
        --all_;
        if (const auto same = from_.find(from); --same->second == 0)
            from_.erase(same);
    }

private:
    int all_ = 0;
    std::map<net::ip::address, int> from_;
};

/// IPv4 addresses that IPv6 sockets see are IPv4 addresses; of IPv6 a network of 64 bits counts as one.
net::ip::address counted_address(const net::ip::address& address) {
    if (address.is_v4() || address.is_loopback())
        return address;
    if (address.to_v6().is_v4_mapped())
        return net::ip::make_address_v4(net::ip::v4_mapped, address.to_v6());
    auto bytes = address.to_v6().to_bytes();
    std::fill(bytes.begin() + 8, bytes.end(), std::uint8_t(0));
    return net::ip::address_v6(bytes);
}

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

    Parts(WebSettings what, Welcome how) : settings(std::move(what)), welcome(std::move(how)) {}

    void listen();
    void accept();
    void let_in(websocket::stream<beast::tcp_stream> browser, http::request<http::empty_body> request,
                const tcp::endpoint& peer);
};

namespace {

/// One that asks for something, by HTTP.
class Asking : public std::enable_shared_from_this<Asking> {
public:
    using Upgrade = std::function<void(websocket::stream<beast::tcp_stream>, http::request<http::empty_body>)>;

    Asking(tcp::socket socket, const WebSettings& settings, bool this_machine_alone, const net::ip::address& from,
           Crowd& asking, Upgrade upgrade)
        : stream_(std::move(socket)), settings_(settings), this_machine_alone_(this_machine_alone), from_(from),
          asking_(asking), upgrade_(std::move(upgrade)) {
        asking_.add(from_);
    }
    ~Asking() { asking_.remove(from_); }

    void read() {
        parser_.emplace();
        parser_->header_limit(largest_header);
        parser_->body_limit(0);
        stream_.expires_after(std::chrono::milliseconds(int(1000 * settings_.patience_s)));
        http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
            if (!error)
                self->answer();
        });
    }

private:
    void answer() {
        const auto request = parser_->release();
        const std::string_view host = view(request[http::field::host]), origin = view(request[http::field::origin]);
        const std::string target(view(request.target()));
        if (this_machine_alone_ && !is_own_name(host))
            return say(http::status::forbidden, "this server is known as localhost alone\n", request);
        if (websocket::is_upgrade(request)) {
            if (!is_own_page(origin, host))
                return say(http::status::forbidden, "only the page of this server may have the stream\n", request);
            if (target != "/stream")
                return say(http::status::not_found, "the stream is /stream\n", request);
            return accept_viewer(request);
        }
        if (request.method() != http::verb::get)
            return say(http::status::method_not_allowed, "only GET is known here\n", request);
        if (target == "/")
            return lead_to_page(request);
        if (target == "/?live=stream" || target.starts_with("/?live=stream&"))
            return say(http::status::ok, settings_.page, request, "text/html; charset=utf-8");
        say(http::status::not_found, "there is the page / alone\n", request);
    }

    static std::string_view view(boost::beast::string_view text) { return {text.data(), text.size()}; }

    void accept_viewer(const http::request<http::empty_body>& request) {
        // The WebSocket has times of its own.
        stream_.expires_never();
        upgrade_(websocket::stream<beast::tcp_stream>(std::move(stream_)), request);
    }

    void lead_to_page(const http::request<http::empty_body>& request) {
        auto response = made(http::status::found, request);
        response->set(http::field::location, "/?live=stream");
        send(response);
    }

    void say(http::status status, const std::string& text, const http::request<http::empty_body>& request,
             const char* type = "text/plain") {
        auto response = made(status, request);
        response->set(http::field::content_type, type);
        response->body() = text;
        send(response);
    }

    using Response = http::response<http::string_body>;
    static std::shared_ptr<Response> made(http::status status, const http::request<http::empty_body>& request) {
        auto response = std::make_shared<Response>(status, request.version());
        response->set("X-Content-Type-Options", "nosniff");
        response->set("X-Frame-Options", "DENY");
        response->set(http::field::cache_control, "no-cache");
        response->keep_alive(false);
        return response;
    }

    void send(const std::shared_ptr<Response>& response) {
        response->prepare_payload();
        http::async_write(stream_, *response, [self = shared_from_this(), response](Error, std::size_t) {
            Error ignored;
            self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
        });
    }

    beast::tcp_stream stream_;
    const WebSettings& settings_;
    bool this_machine_alone_;
    net::ip::address from_;
    Crowd& asking_;
    Upgrade upgrade_;
    beast::flat_buffer buffer_{largest_header};
    std::optional<http::request_parser<http::empty_body>> parser_;
};

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
        throw InputError(expected_found("--web " + std::to_string(settings.port),
                                        "an address that is free and this machine's", error.message()));
}

void WebDoor::Parts::accept() {
    acceptor.async_accept([this](Error error, tcp::socket socket) {
        if (!acceptor.is_open())
            return;
        pause.expires_after(between_connections);
        pause.async_wait([this](Error cancelled) {
            if (!cancelled)
                accept();
        });
        Error gone;
        const tcp::endpoint peer = error ? tcp::endpoint() : socket.remote_endpoint(gone);
        const net::ip::address from = counted_address(peer.address());
        if (error || gone || !asking.has_room_for(from))
            return;
        socket.set_option(tcp::no_delay(true), gone);
        const auto upgrade = [this, peer](websocket::stream<beast::tcp_stream> browser,
                                          http::request<http::empty_body> request) {
            let_in(std::move(browser), std::move(request), peer);
        };
        std::make_shared<Asking>(std::move(socket), settings, this_machine_alone, from, asking, upgrade)->read();
    });
}

void WebDoor::Parts::let_in(websocket::stream<beast::tcp_stream> browser, http::request<http::empty_body> request,
                            const tcp::endpoint& peer) {
    const auto patience = std::chrono::milliseconds(int(1000 * settings.patience_s));
    // Pings are answered by whoever reads.
    browser.set_option(websocket::stream_base::timeout{patience, patience, true});
    browser.read_message_max(largest_message);
    const auto opening = std::make_shared<websocket::stream<beast::tcp_stream>>(std::move(browser));
    const auto asked = std::make_shared<http::request<http::empty_body>>(std::move(request));
    opening->async_accept(*asked, [this, opening, asked, peer](Error failed) {
        std::array<int, 2> ends{};
        if (failed || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
            return;
        Descriptor own_end(ends[0]), server_end(ends[1]);
        net::local::stream_protocol::socket own(io);
        Error error;
        own.assign(net::local::stream_protocol(), own_end.number(), error);
        if (error)
            return;
        own_end.release();
        std::make_shared<Bridge>(std::move(*opening), std::move(own))->start();
        welcome(std::move(server_end), peer.address().to_string(), peer.port());
    });
}

WebDoor::WebDoor(WebSettings settings, Welcome welcome)
    : parts_(std::make_unique<Parts>(std::move(settings), std::move(welcome))) {
    parts_->listen();
    const tcp::endpoint at = parts_->acceptor.local_endpoint();
    const std::string host = at.address().to_string();
    url_ = "http://" + (at.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(at.port()) + "/";
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
