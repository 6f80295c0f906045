#pragma once
/// A rendered sequence coded by `equistream encode` as a child process.
#include <equistream/camera.h>
#include <equistream/elapsed.h>

#include <asio/posix/stream_descriptor.hpp>
#include <asio/signal_set.hpp>

#include <cstdint>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace equistream::serve {

/// Waits for `equistream encode` with these arguments, whose report goes to standard error. True: done. False: one of
/// the signals of `stop` came, and the child has been ended. Throws cli::ChildFailed where the child fails. `io` is
/// the context of `stop` and has nothing else to do.
bool run_encode(asio::io_context& io, asio::signal_set& stop, const std::vector<std::string>& arguments);

/// How often a renderer that has died is started again: at most three times an hour.
class Restarts {
public:
    /// It is counted, if it is allowed.
    bool allows(Clock::time_point now);

private:
    std::vector<Clock::time_point> restarts_;
};

// `equistream render --follow` as a child that stays: orders go to its standard input, answers come from its standard
// output (host-adapters/common/follow.h). One thread: that of the io_context.

struct FrameOrder {
    std::int64_t frame = 0;
    std::uint32_t spp = 1;
    std::optional<std::uint32_t> base_spp;  ///< of the sphere around a window; nothing: `spp`
    int window_halvings = 0;                ///< of the window's pixels
    std::optional<Pose> head;               ///< nothing: where the scene's path has it
    std::optional<glm::dvec3> gaze;         ///< around which a window lies, in the world; nothing: straight ahead
};

struct RenderedFrame {
    std::int64_t frame = 0;
    std::string file;
    std::string window;  ///< file of the window within it; empty: none
    double render_s = 0, write_s = 0;
};

class RenderChild {
public:
    struct Events {
        std::function<void(double frames_per_second)> ready;
        std::function<void(const RenderedFrame&)> rendered;
        /// It has ended without being told to, or says what cannot be understood: what to throw.
        std::function<void(std::exception_ptr)> failed;
    };

    /// Throws WorkError where it cannot be started.
    RenderChild(asio::io_context& io, const std::string& program, const std::vector<std::string>& arguments,
                Events events);
    /// Ends it and waits until it has.
    ~RenderChild();
    RenderChild(const RenderChild&) = delete;
    RenderChild& operator=(const RenderChild&) = delete;

    /// One at a time, after `ready` or `rendered`.
    void order(const FrameOrder& order);
    /// From here on nothing is told of it any more.
    void end();

private:
    void listen();
    void hear(const std::string& line);
    void hear_end();
    void hear_nonsense(const asio::error_code& error);

    std::string program_;
    asio::posix::stream_descriptor orders_, answers_;
    Events events_;
    std::string read_;
    int process_ = 0;  // 0: has been waited for
    bool is_ready_ = false, is_told_to_end_ = false;
};

}  // namespace equistream::serve
