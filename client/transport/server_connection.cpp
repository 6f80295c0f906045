#include "server_connection.h"

#include "address.h"
#include "secret.h"
#include "srt_wire.h"
#include "wire.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/steady_timer.hpp>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace equistream {

using asio::ip::tcp;

namespace {

constexpr std::chrono::milliseconds between_questions{50};

/// Of what has arrived and was not read yet; more waits with the server.
constexpr std::size_t max_kept_bytes = 1 << 18;

/// Of it all addresses of a server together may take so much: then who waits is told what went wrong.
constexpr double share_of_patience = 0.9;

/// What the caller is to throw.
struct Problem {
    std::string expected, found;
};

/// Of the address's secret or the environment's; null where there is to be none.
std::shared_ptr<asio::ssl::context> context_for(const ServerAddress& address) {
    if (!is_encrypted(address.scheme))
        return nullptr;
    const char* const variable = std::getenv(secret_variable);
    const std::string secret = address.secret.empty() && variable != nullptr ? variable : address.secret;
    const std::string where = address.text();
    if (secret.empty())
        throw InputError(
            expected_found(where, std::string("the server's secret: SECRET@HOST:PORT, or ") + secret_variable, "none"));
    require_secret(secret, where);
    return secret_context(secret, TlsRole::client);
}

}  // namespace

/// Where a host name leads. Nobody waits for its thread: the system's look-up takes seconds, and cannot be broken off.
class NameLookup {
public:
    using Done = std::function<void(const asio::error_code&, const std::vector<tcp::endpoint>&)>;

    /// `done` runs in `io`, unless the look-up is destroyed before.
    NameLookup(asio::io_context& io, const ServerAddress& address, Done done) : shared_(std::make_shared<Shared>()) {
        shared_->io = &io;
        std::thread([shared = shared_, address, done = std::move(done)] {
            asio::io_context own;
            asio::error_code error;
            std::vector<tcp::endpoint> endpoints;
            for (const auto& found : tcp::resolver(own).resolve(address.host, std::to_string(address.port), error))
                endpoints.push_back(found.endpoint());
            const std::lock_guard lock(shared->mutex);
            if (shared->io != nullptr)
                asio::post(*shared->io, [done, error, endpoints] { done(error, endpoints); });
        }).detach();
    }
    ~NameLookup() {
        const std::lock_guard lock(shared_->mutex);
        shared_->io = nullptr;
    }
    NameLookup(const NameLookup&) = delete;
    NameLookup& operator=(const NameLookup&) = delete;

private:
    struct Shared {
        std::mutex mutex;
        asio::io_context* io = nullptr;
    };
    std::shared_ptr<Shared> shared_;
};

/// The thread and what it shares.
class ServerConnection::Line {
public:
    enum class Waited { done, interrupted, too_long };

    Line(const ServerAddress& address, const Patience& patience)
        : context_(context_for(address)), silence_s_(patience.silence_s), connect_s_(patience.connect_s),
          thread_([this] { io_.run(); }) {
        asio::post(io_, [this, address] { look_up(address); });
    }
    ~Line() {
        io_.stop();
        thread_.join();
    }

    Waited wait_until_open(double limit_s, const std::function<bool()>& interrupted) {
        return wait([this] { return is_open_ || problem_; }, limit_s, interrupted);
    }
    Waited wait_for_bytes(double limit_s, const std::function<bool()>& interrupted) {
        return wait([this] { return has_ended_ || begin_ < arrived_.size(); }, limit_s, interrupted);
    }
    /// Once all has been taken: how the connection broke; empty: the server ended it.
    std::string cut() {
        const std::lock_guard lock(mutex_);
        return cut_;
    }
    const std::optional<Problem>& problem() const { return problem_; }  // once it is open, or cannot be

    /// None: they have ended.
    std::size_t take(std::span<std::uint8_t> bytes) {
        const std::lock_guard lock(mutex_);
        const std::size_t count = std::min(bytes.size(), arrived_.size() - begin_);
        std::copy_n(arrived_.begin() + std::ptrdiff_t(begin_), count, bytes.begin());
        begin_ += count;
        if (begin_ == arrived_.size()) {
            arrived_.clear();
            begin_ = 0;
        }
        if (is_full_ && arrived_.empty()) {
            is_full_ = false;
            asio::post(io_, [this] { read(); });
        }
        return count;
    }

    bool send(std::span<const std::uint8_t> bytes) {
        const std::lock_guard lock(mutex_);
        if (!is_open_ || has_ended_ || !unsent_.empty())
            return false;
        unsent_.assign(bytes.begin(), bytes.end());
        asio::post(io_, [this] { write(0); });
        return true;
    }

private:
    template <typename Done>
    Waited wait(Done is_done, double limit_s, const std::function<bool()>& interrupted) {
        const auto start = Clock::now();
        while (true) {
            {
                std::unique_lock lock(mutex_);
                if (changed_.wait_for(lock, between_questions, is_done))
                    return Waited::done;
            }
            if (interrupted && interrupted())
                return Waited::interrupted;
            if (seconds_since(start) > limit_s)
                return Waited::too_long;
        }
    }

    // From here on in the thread.

    void look_up(const ServerAddress& address) {
        parity_ = address.parity.value_or(usual_parity);
        const auto done = [this, is_srt = address.scheme == Scheme::srt](const asio::error_code& error,
                                                                         const std::vector<tcp::endpoint>& found) {
            found_ = found;
            if (error)
                fail("a server", error);
            else if (is_srt)
                connect_srt(0);
            else
                connect_tcp(0);
        };
        name_lookup_.emplace(io_, address, done);
    }
    double patience_of_each_s() const { return share_of_patience * connect_s_ / double(found_.size()); }
    /// One address after the other, until a server answers. The system alone would wait minutes for the first. The last
    /// one has all the time that is left: it ends by wait_until_open.
    void connect_tcp(std::size_t index) {
        asio::error_code ignored;
        socket_.close(ignored);
        const bool is_last = index + 1 == found_.size();
        const std::chrono::duration<double> each(patience_of_each_s());
        next_address_.expires_at(is_last ? Clock::time_point::max()
                                         : Clock::now() + std::chrono::duration_cast<Clock::duration>(each));
        if (!is_last)
            next_address_.async_wait([this](const asio::error_code& error) {
                asio::error_code no_matter;
                if (!error && next_address_.expiry() <= Clock::now())  // else it was the time of the address before
                    socket_.close(no_matter);
            });
        socket_.async_connect(found_[index], [this, index, is_last](const asio::error_code& error) {
            const bool is_connected = !error && socket_.is_open();
            if (!is_connected && !is_last)
                return connect_tcp(index + 1);
            next_address_.cancel();
            if (!is_connected)
                return fail("a server", error);
            prepare(socket_, silence_s_);
            open(context_ ? tls_wire(std::move(socket_), context_, false) : tcp_wire(std::move(socket_)));
        });
    }
    /// One address after the other, until a server answers.
    void connect_srt(std::size_t index) {
        const asio::ip::udp::endpoint endpoint(found_[index].address(), found_[index].port());
        std::unique_ptr<Wire> wire;
        try {
            wire = srt_wire(io_.get_executor(), endpoint, context_, silence_s_, patience_of_each_s(), parity_);
        } catch (const WorkError& error) {
            return change([&] { problem_ = {"a socket for SRT", error.what()}; });
        }
        open(std::move(wire), [this, next = index + 1] {
            if (next == found_.size())
                return false;
            connect_srt(next);
            return true;
        });
    }
    /// `connect_elsewhere` is asked where no server answers; false: there is nowhere else.
    void open(std::unique_ptr<Wire> wire, std::function<bool()> connect_elsewhere = {}) {
        wire_ = std::move(wire);
        wire_->open([this, connect_elsewhere = std::move(connect_elsewhere)](const asio::error_code& refused) {
            const bool is_nobody = connect_elsewhere && refused.category() == asio::system_category();
            if (refused && is_nobody && connect_elsewhere())
                return;
            if (refused == other_parity)
                return change([&] {
                    problem_ = {formatted("a server with the same ?parity=N (here %d)", parity_), "one with another"};
                });
            if (refused)
                return fail(is_nobody                                 ? "a server"
                            : !connect_elsewhere && hangs_up(refused) ? "a server that has room for another viewer"
                                                                      : "a server with this secret",
                            refused);
            change([this] { is_open_ = true; });
            read();
        });
    }
    /// By TLS who does not know the secret is told so, and who finds no room is not; by SRT both are cut off.
    static bool hangs_up(const asio::error_code& error) {
        return error == asio::error::eof || error == asio::error::connection_reset ||
               error == asio::ssl::error::stream_truncated;
    }
    void fail(const std::string& expected, const asio::error_code& error) {
        change([&] { problem_ = {expected, error.message()}; });
    }
    void read() {
        wire_->read_some(chunk_, [this](const asio::error_code& error, std::size_t count) {
            bool more = false;
            change([&] {
                arrived_.insert(arrived_.end(), chunk_.begin(), chunk_.begin() + std::ptrdiff_t(count));
                has_ended_ = bool(error);
                // Without encryption nobody can tell an end from a cut; the stream's own pictures do.
                if (context_ && error && error != asio::error::eof)
                    cut_ = error.message();
                is_full_ = !error && arrived_.size() >= max_kept_bytes;
                more = !has_ended_ && !is_full_;
            });
            if (more)
                read();
        });
    }
    /// What is sent stays as it is until it has gone.
    void write(std::size_t begin) {
        const std::span rest = std::span(unsent_).subspan(begin);
        wire_->write_some(std::span(reinterpret_cast<const char*>(rest.data()), rest.size()),
                          [this, begin](const asio::error_code& error, std::size_t count) {
                              if (error || begin + count == unsent_.size())
                                  change([this] { unsent_.clear(); });
                              else
                                  write(begin + count);
                          });
    }
    template <typename Change>
    void change(Change what) {
        {
            const std::lock_guard lock(mutex_);
            what();
        }
        changed_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    bool is_open_ = false, has_ended_ = false, is_full_ = false;
    std::optional<Problem> problem_;
    std::string cut_;
    std::vector<char> arrived_;  // read up to begin_
    std::size_t begin_ = 0;
    std::vector<std::uint8_t> unsent_;  // not empty: the thread is sending it

    std::shared_ptr<asio::ssl::context> context_;  // null: not encrypted
    double silence_s_, connect_s_;
    asio::io_context io_{1};
    asio::executor_work_guard<asio::io_context::executor_type> work_{io_.get_executor()};
    tcp::socket socket_{io_};
    asio::steady_timer next_address_{io_};
    std::vector<tcp::endpoint> found_;
    std::unique_ptr<Wire> wire_;
    std::array<char, 1 << 16> chunk_{};
    int parity_ = usual_parity;
    std::optional<NameLookup> name_lookup_;
    std::thread thread_;  // last: it begins when all else is there
};

ServerConnection::ServerConnection(const std::string& address, PoseSender* poses, std::function<bool()> interrupted,
                                   const Patience& patience)
    : poses_(poses), interrupted_(std::move(interrupted)), patience_(patience) {
    const auto server = parse_server_address(address);
    if (!server || server->host.empty() || server->port == 0)
        throw InputError(expected_found(
            without_secrets(address),
            "tcp://HOST:PORT with a port of 1 to 65535, tls://SECRET@HOST:PORT, or srt://SECRET@HOST:PORT, with "
            "?parity=2 to 100 if wanted",
            "another address"));
    line_ = std::make_unique<Line>(*server, patience_);
    switch (line_->wait_until_open(patience_.connect_s, interrupted_)) {
    case Line::Waited::too_long:
        throw WorkError(
            formatted("%s: the server did not answer for %g s", server->text().c_str(), patience_.connect_s));
    case Line::Waited::interrupted:
        give_up();
        return;
    case Line::Waited::done:
        break;
    }
    if (const auto& problem = line_->problem())
        throw InputError(expected_found(server->text(), problem->expected, problem->found));
    if (poses_ != nullptr)
        poses_->use([this](std::span<const std::uint8_t> bytes) { return line_->send(bytes); });
}

ServerConnection::~ServerConnection() {
    if (poses_ != nullptr)
        poses_->use(nullptr);
}

/// Nobody sends any more when it returns.
void ServerConnection::give_up() {
    if (poses_ != nullptr)
        poses_->use(nullptr);
    line_.reset();
    has_ended_ = true;
}

std::size_t ServerConnection::read(std::span<std::uint8_t> bytes) {
    // libav reads on beyond an end.
    if (has_ended_)
        return 0;
    // Bytes that nothing can be made of may come without a pause: then nothing below ever waits.
    if (interrupted_ && interrupted_()) {
        has_ended_ = true;
        return 0;
    }
    const double limit_s = has_sent_ ? patience_.silence_s : patience_.first_bytes_s;
    switch (line_->wait_for_bytes(limit_s, interrupted_)) {
    case Line::Waited::too_long:
        give_up();
        throw WorkError(formatted("the server sent nothing for %g s", limit_s));
    case Line::Waited::interrupted:
        give_up();
        return 0;
    case Line::Waited::done:
        break;
    }
    const std::size_t count = line_->take(bytes);
    has_ended_ = count == 0;
    if (has_ended_ && !has_sent_)
        throw WorkError("the server closed the connection before sending anything; it may be full (serve --viewers)");
    has_sent_ = true;
    if (const std::string cut = has_ended_ ? line_->cut() : ""; !cut.empty())
        throw WorkError("the connection to the server broke: " + cut);
    return count;
}

StreamReadOptions connected(const std::string& source, StreamReadOptions options, PoseSender* poses) {
    if (!names_server(source))
        return options;
    const auto connection = std::make_shared<ServerConnection>(source, poses, options.interrupted);
    options.read = [connection](std::span<std::uint8_t> bytes) { return connection->read(bytes); };
    return options;
}

}  // namespace equistream
