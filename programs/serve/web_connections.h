#pragma once
/// Browsers' connections to web_door.cpp, which alone sees this: what they ask for by HTTP, and the stream by
/// WebSocket. `Stream` is plain TCP, or TLS over it.
#include "web_door.h"

#include <client/transport/congestion.h>
#include <client/transport/under_way.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>

#include <openssl/crypto.h>

#include <poll.h>

#include <array>
#include <charconv>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace equistream::serve {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
namespace net = boost::asio;
using net::ip::tcp;
using Error = boost::system::error_code;
/// Read no faster than it is told.
using PlainStream = beast::basic_stream<tcp, net::any_io_executor, beast::simple_rate_policy>;
using TlsStream = beast::ssl_stream<PlainStream>;

inline constexpr std::size_t max_header_bytes = 8192;
/// So much is sent to a browser at a time, and waited for.
inline constexpr std::size_t piece_bytes = 1 << 14;
/// Connections that have not become viewers, of all and of one address but for this machine's: more are closed at once.
inline constexpr int max_asking = 64, max_asking_from_one = 16;

/// The name without its port: "127.0.0.1:80" or "[::1]:80".
inline std::string_view name_of(std::string_view host) {
    const auto end = host.starts_with('[') ? host.find(']') : host.rfind(':');
    return host.substr(0, end == std::string_view::npos ? end : end + (host.starts_with('[') ? 1 : 0));
}

/// Where only this machine is listened to, nobody may come here by another name than its three and that of `address`,
/// which is listened on. Else a stranger's name that leads here would let the stranger's pages in.
inline bool is_own_name(std::string_view host, std::string_view address = {}) {
    const std::string_view name = name_of(host);
    return name == "localhost" || name == "127.0.0.1" || name == "[::1]" || (!address.empty() && name == address);
}

/// Whether a page from this server asks.
inline bool is_own_page(std::string_view origin, std::string_view host) {
    return origin == "http://" + std::string(host) || origin == "https://" + std::string(host);
}

/// What stands behind "?key=", without its percent signs.
inline std::string key_in(std::string_view target) {
    constexpr std::string_view before = "?key=";
    const auto at = target.find(before);
    std::string key;
    if (at == target.npos)
        return key;
    for (target.remove_prefix(at + before.size()); !target.empty() && target.front() != '&';) {
        unsigned char number = 0;
        const char* const digits = target.data() + 1;
        if (target.front() == '%' && target.size() > 2 &&
            std::from_chars(digits, digits + 2, number, 16).ptr == digits + 2) {
            key += char(number);
            target.remove_prefix(3);
        } else {
            key += target.front();
            target.remove_prefix(1);
        }
    }
    return key;
}

/// Takes as long wherever they differ.
inline bool is_same_secret(const std::string& said, const std::string& secret) {
    return said.size() == secret.size() && CRYPTO_memcmp(said.data(), secret.data(), secret.size()) == 0;
}

/// Who has connected and is no viewer yet.
class Crowd {
public:
    /// A connection's, for as long as it counts. The crowd outlives it.
    class Place {
    public:
        Place(Crowd& crowd, const net::ip::address& from) : crowd_(&crowd), from_(from) { crowd.add(from); }
        ~Place() { leave(); }
        Place(Place&& other) noexcept : crowd_(std::exchange(other.crowd_, nullptr)), from_(other.from_) {}
        Place& operator=(Place&&) = delete;
        void leave() {
            if (Crowd* const crowd = std::exchange(crowd_, nullptr))
                crowd->remove(from_);
        }

    private:
        Crowd* crowd_;
        net::ip::address from_;
    };

    bool has_room_for(const net::ip::address& from) const {
        const auto same = from_.find(from);
        return all_ < max_asking && (from.is_loopback() || same == from_.end() || same->second < max_asking_from_one);
    }

private:
    void add(const net::ip::address& from) {
        ++from_[from];
        ++all_;
    }
    void remove(const net::ip::address& from) {
        --all_;
        if (const auto same = from_.find(from); --same->second == 0)
            from_.erase(same);
    }

    int all_ = 0;
    std::map<net::ip::address, int> from_;
};

/// Between a WebSocket and one end of a pair of local sockets, both ways. What is not read on one side is not read on
/// the other: the server's viewer keeps to its limits.
template <typename Stream>
class Bridge : public std::enable_shared_from_this<Bridge<Stream>> {
public:
    /// `patience`: the server's, with a viewer that does not read.
    Bridge(websocket::stream<Stream> browser, net::local::stream_protocol::socket server, Crowd::Place place,
           std::chrono::milliseconds patience)
        : browser_(std::move(browser)), server_(std::move(server)), patience_(patience), place_(std::move(place)) {}

    void start() {
        browser_.binary(true);
        send();
        hear();
    }

private:
    /// Nothing is taken from the server that the line has no room for: there it may still be left out.
    void send() {
        const double now_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        under_way_.see(now_s, sent_, unacknowledged(beast::get_lowest_layer(browser_).socket().native_handle()));
        if (!under_way_.is_too_much(now_s))
            return send_next();
        look_.expires_after(std::chrono::milliseconds(int(1000 * UnderWay::between_looks_s)));
        look_.async_wait([self = this->shared_from_this()](Error cancelled) {
            if (!cancelled)
                self->send();
        });
    }

    void send_next() {
        server_.async_read_some(net::buffer(block_), [self = this->shared_from_this()](Error error, std::size_t count) {
            if (error)
                return self->end();
            self->has_sent_ = true;
            self->place_.leave();  // the server has let it in, and counts it
            self->write(count);
        });
    }

    /// Hangs up on a browser that stops reading. The server usually drops its viewer first, but this side cannot see
    /// that while a write waits.
    void write(std::size_t count) {
        unread_.expires_after(2 * patience_);
        unread_.async_wait([weak = this->weak_from_this()](Error cancelled) {
            const auto self = weak.lock();
            if (!cancelled && self && self->unread_.expiry() <= std::chrono::steady_clock::now())
                self->hang_up();
        });
        browser_.async_write(net::buffer(block_, count),
                             [self = this->shared_from_this(), count](Error failed, std::size_t) {
                                 // Also where its handler is queued already.
                                 self->unread_.expires_at(std::chrono::steady_clock::time_point::max());
                                 if (failed)
                                     return self->hang_up();
                                 self->sent_ += std::int64_t(count);
                                 self->send();
                             });
    }

    /// The server has said all, or has closed both ways: it has cut its viewer off, or has not let it in.
    void end() {
        pollfd asked{server_.native_handle(), 0, 0};
        const bool is_cut = ::poll(&asked, 1, 0) > 0 && (asked.revents & POLLHUP) != 0;
        websocket::close_reason reason(websocket::close_code::normal);
        if (is_cut && has_sent_)
            reason = {websocket::close_code::internal_error, "the stream was cut off"};
        else if (is_cut)
            reason = {websocket::close_code::try_again_later, "no room for another viewer"};
        browser_.async_close(reason, [self = this->shared_from_this()](Error) { self->hang_up(); });
    }

    void hear() {
        browser_.async_read(heard_, [self = this->shared_from_this()](Error error, std::size_t) {
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
        look_.cancel();
        server_.close(ignored);
        beast::get_lowest_layer(browser_).close();
    }

    websocket::stream<Stream> browser_;
    net::local::stream_protocol::socket server_;
    std::chrono::milliseconds patience_;
    net::steady_timer unread_{browser_.get_executor()}, look_{browser_.get_executor()};
    std::array<char, piece_bytes> block_;
    UnderWay under_way_;
    std::int64_t sent_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    beast::flat_buffer heard_;
    bool has_sent_ = false;
    Crowd::Place place_;  // also of one that is refused, until it has gone
};

/// One that asks for something, by HTTP.
template <typename Stream>
class Asking : public std::enable_shared_from_this<Asking<Stream>> {
public:
    using Upgrade = std::function<void(websocket::stream<Stream>, http::request<http::empty_body>, Crowd::Place)>;

    Asking(Stream stream, const WebSettings& settings, bool this_machine_alone, const net::ip::address& from,
           Crowd& asking, Upgrade upgrade)
        : stream_(std::move(stream)), settings_(settings), this_machine_alone_(this_machine_alone),
          place_(asking, from), upgrade_(std::move(upgrade)) {}

    void begin() {
        begin_waiting();
        if constexpr (is_encrypted)
            stream_.async_handshake(net::ssl::stream_base::server, [self = this->shared_from_this()](Error error) {
                if (!error)
                    self->read();
            });
        else
            read();
    }

private:
    static constexpr bool is_encrypted = !std::is_same_v<Stream, PlainStream>;

    /// Patience begins anew.
    void begin_waiting() {
        beast::get_lowest_layer(stream_).expires_after(std::chrono::milliseconds(int(1000 * settings_.patience_s)));
    }

    void read() {
        parser_.emplace();
        parser_->header_limit(max_header_bytes);
        parser_->body_limit(0);
        http::async_read(stream_, buffer_, *parser_, [self = this->shared_from_this()](Error error, std::size_t) {
            if (!error)
                self->answer();
        });
    }

    void answer() {
        const auto request = parser_->release();
        const std::string_view host = view(request[http::field::host]), origin = view(request[http::field::origin]);
        const std::string target(view(request.target()));
        if (this_machine_alone_ && !is_own_name(host, settings_.address))
            return say(http::status::forbidden,
                       "expected localhost or the address that this server listens on, found another host name\n",
                       request);
        if (websocket::is_upgrade(request)) {
            if (!is_own_page(origin, host))
                return say(http::status::forbidden,
                           "expected a request from this server's own page, found another origin\n", request);
            if (target != "/stream" && !target.starts_with("/stream?"))
                return say(http::status::not_found, "expected /stream, found another path\n", request);
            if (!settings_.secret.empty() && !is_same_secret(key_in(target), settings_.secret))
                return say(http::status::forbidden,
                           "expected the key in the address that serve printed, found none or another\n", request);
            return accept_viewer(request);
        }
        if (request.method() != http::verb::get)
            return say(http::status::method_not_allowed, "expected a GET request, found another method\n", request);
        if (target == "/")
            return lead_to_page(request);
        if (target == "/?live=stream" || target.starts_with("/?live=stream&"))
            return say(http::status::ok, settings_.page, request, "text/html; charset=utf-8");
        say(http::status::not_found, "expected the page /, found another path\n", request);
    }

    static std::string_view view(boost::beast::string_view text) { return {text.data(), text.size()}; }

    void accept_viewer(const http::request<http::empty_body>& request) {
        // The WebSocket has times of its own.
        beast::get_lowest_layer(stream_).expires_never();
        upgrade_(websocket::stream<Stream>(std::move(stream_)), request, std::move(place_));
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
        response->set("Referrer-Policy", "no-referrer");
        response->set(http::field::cache_control, "no-cache");
        response->keep_alive(false);
        return response;
    }

    using Serializer = http::response_serializer<http::string_body>;

    void send(const std::shared_ptr<Response>& response) {
        response->prepare_payload();
        const auto serializer = std::make_shared<Serializer>(*response);
        serializer->limit(piece_bytes);
        send_piece(response, serializer);
    }

    void send_piece(const std::shared_ptr<Response>& response, const std::shared_ptr<Serializer>& serializer) {
        begin_waiting();
        http::async_write_some(stream_, *serializer,
                               [self = this->shared_from_this(), response, serializer](Error error, std::size_t) {
                                   if (error || serializer->is_done())
                                       return self->end();
                                   self->send_piece(response, serializer);
                               });
    }

    void end() {
        if constexpr (is_encrypted) {
            stream_.async_shutdown([self = this->shared_from_this()](Error) {});
        } else {
            Error ignored;
            stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
        }
    }

    Stream stream_;
    const WebSettings& settings_;
    bool this_machine_alone_;
    Crowd::Place place_;
    Upgrade upgrade_;
    beast::flat_buffer buffer_{max_header_bytes};
    std::optional<http::request_parser<http::empty_body>> parser_;
};

}  // namespace equistream::serve
