#include "server.h"

#include "listen_address.h"

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
    const int number = ++figures_.viewers;
    const auto viewer = std::make_shared<Viewer>(std::move(socket), programme_.open_feed(), settings_.patience_s);
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

}  // namespace equistream::serve
