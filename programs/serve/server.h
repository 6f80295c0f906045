#pragma once
/// Lets viewers in, up to a limit, and keeps count. One thread: that of the io_context.
#include "feed.h"
#include "server_log.h"
#include "viewer.h"

#include <map>

namespace equistream::serve {

struct ServerSettings {
    int max_viewers = 8;
    double patience_s = 10;  ///< with one that does not read, or not fast enough
    cli::ProgressStyle log = cli::ProgressStyle::automatic;
};

struct ServerFigures {
    int viewers = 0;
    int refused = 0;
    int dropped = 0;
    std::int64_t bytes_sent = 0;
};

class Server {
public:
    /// `acceptor` listens; `programme` must outlive it.
    Server(asio::ip::tcp::acceptor acceptor, Programme& programme, const ServerSettings& settings);

    void start() { accept(); }
    /// There may be more to send to each.
    void wake();
    std::size_t viewers() const { return viewers_.size(); }
    void stop_accepting();
    /// Closes everything, so that the io_context runs out of work.
    void stop();
    const ServerFigures& figures() const { return figures_; }

private:
    void accept();
    void retry_later(const asio::error_code& error);
    void welcome(asio::ip::tcp::socket socket);
    void count_out(int number, const std::string& address, const std::string& how, const std::string& detail);

    asio::ip::tcp::acceptor acceptor_;
    asio::steady_timer retry_;
    Programme& programme_;
    ServerSettings settings_;
    ServerFigures figures_;
    std::map<int, std::shared_ptr<Viewer>> viewers_;
};

}  // namespace equistream::serve
