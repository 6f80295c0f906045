#include "server.h"

#include <equistream/json_text.h>

#include <asio/post.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <utility>

namespace equistream::serve {

namespace {

/// Until the next try where the system had no room for a connection.
constexpr std::chrono::milliseconds before_retry{100};

/// Those that have not shown yet that they know the secret: how many at a time, and for how long.
constexpr std::ptrdiff_t max_arriving = 64, max_arriving_from_one = 16;
constexpr std::chrono::seconds arriving_patience{10};

/// Of viewers from one address, but for this machine's.
constexpr int default_per_address = 4;

std::string left_out_text(std::int64_t lines) {
    return std::to_string(lines) + " log lines about viewers were skipped";
}

void log(cli::ProgressStyle style, const std::string& text, const nlohmann::json& json) {
    if (style != cli::ProgressStyle::none)
        std::fprintf(stderr, "%s\n",
                     style == cli::ProgressStyle::json ? json_text(json).c_str()
                                                       : ("equistream serve: " + text).c_str());
}

}  // namespace

struct Server::Arrival {
    std::unique_ptr<Wire> wire;
    asio::steady_timer patience;
    asio::ip::address from;
    std::string address;
    bool is_browser = false;
};

Server::Server(asio::io_context& io, std::unique_ptr<Door> door, Programme& programme, const ServerSettings& settings)
    : io_(io), door_(std::move(door)), retry_(io), programme_(programme), settings_(settings) {
    if (settings_.web)
        web_ = std::make_unique<WebDoor>(
            *settings_.web, [this](Descriptor end, const std::string& address, std::uint16_t port) {
                const asio::ip::address peer = asio::ip::make_address(address);
                asio::post(io_, [this, peer, port, end = std::move(end)]() mutable {
                    asio::ip::tcp::socket socket(io_);
                    asio::error_code error;
                    socket.assign(peer.is_v6() ? asio::ip::tcp::v6() : asio::ip::tcp::v4(), end.number(), error);
                    if (error)
                        return;
                    end.release();
                    if (!door_->is_open())
                        return;
                    Door::Guest guest{tcp_wire(std::move(socket)), peer, port};
                    welcome(guest, true);
                });
            });
}

Server::~Server() {
    stop();
}

void Server::start() {
    accept();
    if (web_)
        web_->start();
}

void Server::accept() {
    door_->accept([this](const asio::error_code& error, Door::Guest guest) {
        if (!door_->is_open())
            return;
        if (error)
            return retry_later(error);
        welcome(guest, false);
        if (guest.wire)
            door_->turn_away(std::move(guest.wire));
        accept();
    });
}

void Server::retry_later(const asio::error_code& error) {
    tell({"could not be let in", 0, "an address unknown", 0, error.message()});
    retry_.expires_after(before_retry);
    retry_.async_wait([this](const asio::error_code& cancelled) {
        if (!cancelled && door_->is_open())
            accept();
    });
}

std::string Server::refusal(const asio::ip::address& peer) const {
    if (viewers_.size() >= std::size_t(settings_.max_viewers))
        return std::to_string(viewers_.size()) + " viewers are connected already (--viewers)";
    if (!settings_.per_address && peer.is_loopback())
        return {};
    const int most = settings_.per_address.value_or(default_per_address);
    const asio::ip::address from = counted_address(peer);
    const auto same =
        std::ranges::count_if(viewers_, [&](const auto& numbered) { return numbered.second.from == from; });
    return same < most ? std::string()
                       : std::to_string(same) + " viewers from there are connected already (--per-address)";
}

void Server::refuse(const std::string& address, const std::string& why) {
    ++figures_.refused;
    tell({"refused", 0, address, 0, why});
}

void Server::welcome(Door::Guest& guest, bool is_browser) {
    guest.address = unmapped(guest.address);
    const std::string address = peer_text(guest.address, guest.port);
    if (const std::string why = refusal(guest.address); !why.empty())
        return refuse(address, why);
    const auto from_there = std::ranges::count_if(
        arrivals_, [&](const auto& other) { return counted_address(other->from) == counted_address(guest.address); });
    if (std::ssize(arrivals_) >= max_arriving || (!guest.address.is_loopback() && from_there >= max_arriving_from_one))
        return refuse(address, std::to_string(arrivals_.size()) + " viewers are connecting already");
    arrive(std::make_shared<Arrival>(
        Arrival{std::move(guest.wire), asio::steady_timer(io_), guest.address, address, is_browser}));
}

void Server::arrive(const std::shared_ptr<Arrival>& arrival) {
    arrivals_.insert(arrival);
    arrival->patience.expires_after(arriving_patience);
    arrival->patience.async_wait([arrival](const asio::error_code& cancelled) {
        if (!cancelled && arrival->wire)  // it may have come in while this was on its way
            arrival->wire->close();
    });
    arrival->wire->open([this, arrival](const asio::error_code& error) {
        arrival->patience.cancel();
        if (arrivals_.erase(arrival) == 0)  // the server has ended meanwhile
            return;
        if (error)
            refuse(arrival->address, "it did not prove that it has the secret (" + error.message() + ")");
        else
            let_in(*arrival);
        if (arrival->wire && !arrival->is_browser && door_->is_open())
            door_->turn_away(std::move(arrival->wire));
    });
}

void Server::let_in(Arrival& arrival) {
    if (const std::string why = refusal(arrival.from); !why.empty())  // others came while it arrived
        return refuse(arrival.address, why);
    std::unique_ptr<Feed> feed;
    try {
        feed = programme_.open_feed();
    } catch (const std::exception& error) {  // the file has gone, or there is no room for one more
        return refuse(arrival.address, error.what());
    }
    const int number = ++figures_.viewers;
    const std::string address = arrival.address;
    const auto viewer =
        std::make_shared<Viewer>(io_.get_executor(), std::move(arrival.wire), std::move(feed), settings_.patience_s);
    viewers_.emplace(number, Seat{viewer, counted_address(arrival.from)});
    tell({"came", number, address, 0, ""});
    viewer->start([this, number, address](const std::string& how, const std::string& detail) {
        count_out(number, address, how, detail);
    });
}

void Server::count_out(int number, const std::string& address, const std::string& how, const std::string& detail) {
    const auto viewer = viewers_.extract(number).mapped().viewer;
    figures_.bytes_sent += viewer->bytes_sent();
    figures_.dropped += how == "dropped" || how == not_served ? 1 : 0;
    tell({how, number, address, viewer->bytes_sent(), detail});
}

void Server::tell(const ViewerEvent& event) {
    if (!lines_.allows(Clock::now()))
        return;
    ViewerEvent told = event;
    if (const std::int64_t left_out = lines_.take_left_out(); left_out > 0)
        told.detail += (told.detail.empty() ? "" : "; ") + left_out_text(left_out);
    log_event(settings_.log, told);
}

bool LineLimit::allows(Clock::time_point now) {
    const double since_s = std::chrono::duration<double>(now - std::exchange(last_, now)).count();
    lines_ = std::min(at_once, lines_ + a_second * since_s);
    if (lines_ < 1) {
        ++left_out_;
        return false;
    }
    lines_ -= 1;
    return true;
}

/// Over a copy: who is woken may leave.
void Server::wake() {
    const auto all = viewers_;
    for (const auto& [number, guest] : all)
        guest.viewer->wake();
}

void Server::stop_accepting() {
    door_->close();
    if (web_)
        web_->stop_accepting();
    retry_.cancel();
}

void Server::stop() {
    stop_accepting();
    if (const std::int64_t left_out = lines_.take_left_out(); left_out > 0)
        log_note(settings_.log, left_out_text(left_out));
    for (const auto& [number, guest] : viewers_) {
        figures_.bytes_sent += guest.viewer->bytes_sent();
        guest.viewer->stop();
    }
    viewers_.clear();
    for (const auto& arrival : std::exchange(arrivals_, {})) {
        arrival->patience.cancel();
        arrival->wire->close();
    }
    web_.reset();
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

}  // namespace equistream::serve
