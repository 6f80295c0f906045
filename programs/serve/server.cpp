#include "server.h"

#include <equistream/json_text.h>

#include <asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <utility>

namespace equistream::serve {

namespace {

/// Until the next try where the system had no room for a connection.
constexpr std::chrono::milliseconds before_retry{100};

/// "127.0.0.1:51234"
std::string peer_of(const asio::ip::tcp::socket& socket) {
    asio::error_code error;
    const auto endpoint = socket.remote_endpoint(error);
    return error ? "an address unknown" : url_of(endpoint).substr(sizeof "tcp://" - 1);
}

void log(cli::ProgressStyle style, const std::string& text, const nlohmann::json& json) {
    if (style != cli::ProgressStyle::none)
        std::fprintf(stderr, "%s\n",
                     style == cli::ProgressStyle::json ? json_text(json).c_str()
                                                       : ("equistream serve: " + text).c_str());
}

}  // namespace

Server::Server(asio::ip::tcp::acceptor acceptor, Programme& programme, const ServerSettings& settings)
    : acceptor_(std::move(acceptor)), retry_(acceptor_.get_executor()), programme_(programme), settings_(settings) {}

void Server::accept() {
    acceptor_.async_accept([this](const asio::error_code& error, asio::ip::tcp::socket socket) {
        if (!acceptor_.is_open())
            return;
        if (error)
            return retry_later(error);
        welcome(std::move(socket));
        accept();
    });
}

void Server::retry_later(const asio::error_code& error) {
    log_event(settings_.log, {"could not be let in", 0, "an address unknown", 0, error.message()});
    retry_.expires_after(before_retry);
    retry_.async_wait([this](const asio::error_code& cancelled) {
        if (!cancelled && acceptor_.is_open())
            accept();
    });
}

void Server::welcome(asio::ip::tcp::socket socket) {
    const std::string address = peer_of(socket);
    if (viewers_.size() >= std::size_t(settings_.max_viewers)) {
        ++figures_.refused;
        log_event(settings_.log,
                  {"refused", 0, address, 0, std::to_string(viewers_.size()) + " are here already (--viewers)"});
        return;
    }
    std::unique_ptr<Feed> feed;
    try {
        feed = programme_.open_feed();
    } catch (const std::exception& error) {  // the file has gone, or there is no room for one more
        ++figures_.refused;
        log_event(settings_.log, {"refused", 0, address, 0, error.what()});
        return;
    }
    const int number = ++figures_.viewers;
    const auto viewer = std::make_shared<Viewer>(std::move(socket), std::move(feed), settings_.patience_s);
    viewers_.emplace(number, viewer);
    log_event(settings_.log, {"came", number, address, 0, ""});
    viewer->start([this, number, address](const std::string& how, const std::string& detail) {
        count_out(number, address, how, detail);
    });
}

void Server::count_out(int number, const std::string& address, const std::string& how, const std::string& detail) {
    const auto viewer = viewers_.extract(number).mapped();
    figures_.bytes_sent += viewer->bytes_sent();
    figures_.dropped += how == "dropped" ? 1 : 0;
    log_event(settings_.log, {how, number, address, viewer->bytes_sent(), detail});
}

/// Over a copy: who is woken may leave.
void Server::wake() {
    const auto all = viewers_;
    for (const auto& [number, viewer] : all)
        viewer->wake();
}

void Server::stop_accepting() {
    asio::error_code ignored;
    acceptor_.close(ignored);
    retry_.cancel();
}

void Server::stop() {
    stop_accepting();
    for (const auto& [number, viewer] : viewers_) {
        figures_.bytes_sent += viewer->bytes_sent();
        viewer->stop();
    }
    viewers_.clear();
}

void log_event(cli::ProgressStyle style, const ViewerEvent& event) {
    std::string text = "viewer " + (event.viewer > 0 ? std::to_string(event.viewer) + " " : "") + "from " +
                       event.address + " " + event.what;
    if (!event.detail.empty())
        text += ": " + event.detail;
    if (event.bytes > 0)
        text += " (" + std::to_string(event.bytes) + " bytes sent)";
    log(style, text,
        {{"event", event.what},
         {"viewer", event.viewer},
         {"address", event.address},
         {"bytes", event.bytes},
         {"detail", event.detail}});
}

void log_note(cli::ProgressStyle style, const std::string& text) {
    log(style, text, {{"event", "note"}, {"detail", text}});
}

using asio::ip::tcp;

tcp::endpoint parse_listen_address(const std::string& url, const std::string& option) {
    constexpr std::string_view scheme = "tcp://";
    const auto require_right = [&](bool right) {
        cli::require(right, option, "tcp://HOST:PORT with a port of 0 to 65535", "'" + url + "'");
    };
    const auto colon = url.rfind(':');
    require_right(url.starts_with(scheme) && colon >= scheme.size());
    std::uint16_t port = 0;
    const char* const end = url.data() + url.size();
    const auto [stop, not_a_port] = std::from_chars(url.data() + colon + 1, end, port);
    require_right(not_a_port == std::errc() && stop == end);
    std::string host = url.substr(scheme.size(), colon - scheme.size());
    if (host.starts_with('[') && host.ends_with(']'))
        host = host.substr(1, host.size() - 2);
    else
        require_right(host.find_first_of("/:[]") == std::string::npos);
    if (host.empty())
        return {asio::ip::address_v4::loopback(), port};
    asio::io_context io;
    tcp::resolver resolver(io);
    asio::error_code error;
    const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive, error);
    cli::require(!error && !found.empty(), option + " " + url, "a host that is known here", error.message());
    return found.begin()->endpoint();
}

tcp::acceptor bind_to(asio::io_context& io, const tcp::endpoint& address, const std::string& option) {
    tcp::acceptor acceptor(io);
    asio::error_code error;
    acceptor.open(address.protocol(), error);
    if (!error)
        acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error)
        acceptor.bind(address, error);
    cli::require(!error, option + " " + url_of(address), "an address that is free and this machine's", error.message());
    return acceptor;
}

std::string url_of(const tcp::endpoint& address) {
    const std::string host = address.address().to_string();
    return "tcp://" + (address.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(address.port());
}

}  // namespace equistream::serve
