#include "children.h"

#include <equistream/error.h>

#include <programs/cli/process.h>
#include <programs/cli/program.h>

#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/read_until.hpp>
#include <asio/write.hpp>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <initializer_list>
#include <thread>
#include <utility>

extern char** environ;

namespace equistream::serve {

namespace {

constexpr std::size_t longest_line = 65536;

constexpr std::size_t max_restarts = 3;
constexpr std::chrono::hours restarts_within{1};

/// After that a child that was told to end is killed.
constexpr std::chrono::seconds time_to_end{5};

struct Pipe {
    Pipe() {
        if (pipe2(ends, O_CLOEXEC) != 0)
            throw WorkError(std::string("no pipe to the renderer: ") + std::strerror(errno));
    }
    ~Pipe() {
        for (const int end : ends)
            if (end >= 0)
                close(end);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;
    int take(int end) { return std::exchange(ends[end], -1); }

    int ends[2] = {-1, -1};
};

/// Signals of its own, and a group of its own: what a terminal sends the server the server passes on.
class Attributes {
public:
    Attributes() {
        posix_spawnattr_init(&attributes_);
        sigset_t defaults;
        sigemptyset(&defaults);
        sigaddset(&defaults, SIGPIPE);
        posix_spawnattr_setsigdefault(&attributes_, &defaults);
        posix_spawnattr_setpgroup(&attributes_, 0);
        posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    }
    ~Attributes() { posix_spawnattr_destroy(&attributes_); }
    Attributes(const Attributes&) = delete;
    Attributes& operator=(const Attributes&) = delete;
    const posix_spawnattr_t* get() const { return &attributes_; }

private:
    posix_spawnattr_t attributes_;
};

/// `redirected`: each second descriptor is in the child what the first is here.
pid_t spawn(const std::string& program, std::string name, const std::vector<std::string>& arguments,
            std::initializer_list<std::pair<int, int>> redirected, const posix_spawnattr_t* attributes) {
    std::vector<char*> argv{name.data()};
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (const auto& [here, there] : redirected)
        posix_spawn_file_actions_adddup2(&actions, here, there);
    // Sockets are the server's: a child that outlives it would keep its address, and viewers waiting.
    posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    pid_t child = 0;
    const int failure = posix_spawn(&child, program.c_str(), &actions, attributes, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0)
        throw WorkError(program + ": " + std::strerror(failure));
    return child;
}

/// Waits until the child has ended, and returns its status. One that takes too long is killed.
int status_at_end(pid_t child) {
    const auto limit = std::chrono::steady_clock::now() + time_to_end;
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
        if (std::chrono::steady_clock::now() > limit)
            kill(child, SIGKILL);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return status;
}

/// Null: it has done what it should. What a child fails for it has said itself.
std::exception_ptr problem_of(const std::string& program, int status) {
    if (WIFSIGNALED(status))
        return std::make_exception_ptr(WorkError(program + ": ended by signal " + std::to_string(WTERMSIG(status))));
    if (WEXITSTATUS(status) != 0)
        return std::make_exception_ptr(cli::ChildFailed{WEXITSTATUS(status)});
    return nullptr;
}

}  // namespace

bool run_encode(asio::io_context& io, asio::signal_set& stop, const std::vector<std::string>& arguments) {
    asio::signal_set ended(io, SIGCHLD);
    const std::string program = (cli::own_folder() / "equistream-encode").string();
    const pid_t child = spawn(program, "equistream encode", arguments, {{STDERR_FILENO, STDOUT_FILENO}}, nullptr);
    bool stopped = false;
    std::optional<int> status;
    stop.async_wait([&](const asio::error_code& error, int) {
        if (error || status)  // the child has ended, and its number may be another's
            return;
        stopped = true;
        kill(child, SIGKILL);  // it would keep what it has coded, and all its files go with our own
    });
    std::function<void()> look = [&] {
        int found = 0;
        if (waitpid(child, &found, WNOHANG) == child) {
            status = found;
            stop.cancel();
            return;
        }
        ended.async_wait([&](const asio::error_code& error, int) {
            if (!error)
                look();
        });
    };
    look();
    io.run();
    io.restart();
    if (stopped)
        return false;
    if (const auto problem = problem_of(program, *status))
        std::rethrow_exception(problem);
    return true;
}

bool Restarts::allows(Clock::time_point now) {
    std::erase_if(restarts_, [&](Clock::time_point then) { return now - then > restarts_within; });
    if (restarts_.size() >= max_restarts)
        return false;
    restarts_.push_back(now);
    return true;
}

RenderChild::RenderChild(asio::io_context& io, const std::string& program, const std::vector<std::string>& arguments,
                         Events events)
    : program_(program), orders_(io), answers_(io), events_(std::move(events)) {
    Pipe orders, answers;
    const Attributes attributes;
    process_ = spawn(program_, "equistream render", arguments,
                     {{orders.ends[0], STDIN_FILENO}, {answers.ends[1], STDOUT_FILENO}}, attributes.get());
    orders_.assign(orders.take(1));
    answers_.assign(answers.take(0));
    listen();
}

RenderChild::~RenderChild() {
    end();
    if (process_ > 0)
        status_at_end(process_);
}

void RenderChild::listen() {
    asio::async_read_until(answers_, asio::dynamic_buffer(read_, longest_line), '\n',
                           [this](const asio::error_code& error, std::size_t count) {
                               if (is_told_to_end_)
                                   return;
                               if (error == asio::error::eof)
                                   return hear_end();
                               if (error)
                                   return hear_nonsense(error);
                               const std::string line = read_.substr(0, count);
                               read_.erase(0, count);
                               hear(line);
                               if (!is_told_to_end_)
                                   listen();
                           });
}

void RenderChild::hear(const std::string& line) {
    RenderedFrame frame;
    double frames_per_second = 0;
    try {
        const auto answer = nlohmann::json::parse(line);
        if (!is_ready_)
            frames_per_second = answer.at("frames_per_second").get<double>();
        else
            frame = {answer.at("frame").get<std::int64_t>(), answer.at("file").get<std::string>(),
                     answer.value("window", std::string()), answer.at("render_s").get<double>(),
                     answer.at("write_s").get<double>()};
    } catch (const nlohmann::json::exception&) {
        return events_.failed(std::make_exception_ptr(
            WorkError(expected_found(program_, "an answer of render --follow", "'" + line + "'"))));
    }
    if (std::exchange(is_ready_, true))
        events_.rendered(frame);
    else
        events_.ready(frames_per_second);
}

/// It has closed its output, and so is about to end.
void RenderChild::hear_end() {
    const auto problem = problem_of(program_, status_at_end(std::exchange(process_, 0)));
    events_.failed(problem ? problem : std::make_exception_ptr(WorkError(program_ + ": ended unexpectedly")));
}

/// It may go on for ever: whoever hears of it ends it.
void RenderChild::hear_nonsense(const asio::error_code& error) {
    const bool too_long = error == asio::error::not_found;
    events_.failed(std::make_exception_ptr(
        WorkError(expected_found(program_, "answers of at most " + std::to_string(longest_line) + " bytes",
                                 too_long ? "a longer one" : error.message()))));
}

void RenderChild::order(const FrameOrder& order) {
    nlohmann::json line = {{"frame", order.frame}, {"spp", order.spp}};
    if (order.base_spp)
        line["base_spp"] = *order.base_spp;
    if (order.window_halvings > 0)
        line["window_halvings"] = order.window_halvings;
    if (order.head) {
        const glm::dvec3& p = order.head->position_m;
        const glm::dquat& q = order.head->orientation;
        line["position_m"] = {p.x, p.y, p.z};
        line["orientation_wxyz"] = {q.w, q.x, q.y, q.z};
    }
    if (order.gaze)
        line["gaze"] = {order.gaze->x, order.gaze->y, order.gaze->z};
    asio::error_code ignored;  // that it has gone its output tells
    asio::write(orders_, asio::buffer(line.dump() + "\n"), ignored);
}

void RenderChild::end() {
    if (std::exchange(is_told_to_end_, true))
        return;
    asio::error_code ignored;
    orders_.close(ignored);
    answers_.close(ignored);
    if (process_ > 0)
        kill(process_, SIGTERM);
}

}  // namespace equistream::serve
