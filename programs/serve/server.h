#pragma once
/// The server: viewers come, are sent the programme and go, a line each on standard error.
#include "counted_address.h"
#include "door.h"
#include "programmes.h"
#include "viewer.h"
#include "web_door.h"

#include <programs/cli/program.h>

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace equistream::serve {

struct ViewerEvent {
    std::string what;  ///< "came", "left", "has all", "refused", ...
    int viewer = 0;    ///< counted from 1; 0: was never let in
    std::string address;
    std::int64_t bytes = 0;  ///< sent to it
    std::string detail;      ///< may be empty
};

/// In words, as JSON, or not at all, by the same option as progress.
void log_event(cli::ProgressStyle style, const ViewerEvent& event);
/// What else there is to tell.
void log_note(cli::ProgressStyle style, const std::string& text);

/// How many lines strangers may fill a log with: some at once, and then so many a second.
class LineLimit {
public:
    bool allows(Clock::time_point now);
    /// Lines that were not allowed since this was last asked.
    std::int64_t take_left_out() { return std::exchange(left_out_, 0); }

private:
    static constexpr double at_once = 20, a_second = 2;

    double lines_ = at_once;
    Clock::time_point last_{};
    std::int64_t left_out_ = 0;
};

// Lets viewers in, up to a limit, and keeps count. One thread: that of the io_context.

struct ServerSettings {
    int max_viewers = 8;
    /// Of them from one address (counted_address); nothing: 4, and any number from this machine.
    std::optional<int> per_address{};
    double patience_s = 10;  ///< with one that does not read, or not fast enough
    cli::ProgressStyle log = cli::ProgressStyle::automatic;
    std::optional<WebSettings> web{};  ///< browsers come there
};

struct ServerFigures {
    int viewers = 0;
    int refused = 0;
    int dropped = 0;
    std::int64_t bytes_sent = 0;
};

class Server {
public:
    /// `door` listens; `programme` must outlive it. Throws InputError where browsers cannot come where they should.
    /// Its io_context does not run any more once it has gone.
    Server(asio::io_context& io, std::unique_ptr<Door> door, Programme& programme, const ServerSettings& settings);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    void start();
    /// Where browsers come; empty: nowhere.
    std::string web_url() const { return web_ ? web_->url() : std::string(); }
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
    /// Takes the wire of one that is not refused.
    void welcome(Door::Guest& guest, bool is_browser);
    struct Arrival;
    void arrive(const std::shared_ptr<Arrival>& arrival);
    void let_in(Arrival& arrival);
    void count_out(int number, const std::string& address, const std::string& how, const std::string& detail);
    /// Why one from there is not let in; empty: it is.
    std::string refusal(const asio::ip::address& peer) const;
    void refuse(const std::string& address, const std::string& why);
    void tell(const ViewerEvent& event);

    struct Seat {
        std::shared_ptr<Viewer> viewer;
        asio::ip::address from;  ///< as limits count it
    };

    asio::io_context& io_;
    std::unique_ptr<Door> door_;
    asio::steady_timer retry_;
    Programme& programme_;
    ServerSettings settings_;
    ServerFigures figures_;
    std::map<int, Seat> viewers_;
    std::set<std::shared_ptr<Arrival>> arrivals_;  ///< not agreed with yet
    LineLimit lines_;
    std::unique_ptr<WebDoor> web_;  ///< null: browsers do not come
};

}  // namespace equistream::serve
