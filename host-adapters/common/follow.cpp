#include "follow.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/sequence.h>

#include <nlohmann/json.hpp>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace equistream::render_command {
namespace {

using nlohmann::json;

constexpr std::uint32_t max_samples = 1 << 20;

struct Order {
    std::int64_t frame = 0;
    std::uint32_t spp = 1;
    std::uint32_t base_spp = 1;      ///< of the sphere around a window; of one without, `spp`
    std::size_t halvings = 0;        ///< of the window's pixels
    std::optional<Pose> head;        ///< nothing: where the path has it
    std::optional<glm::dvec3> gaze;  ///< a unit direction; nothing: straight ahead
};

std::optional<Pose> pose_in(const json& order) {
    if (!order.contains("position_m"))
        return std::nullopt;
    const auto p = order.at("position_m").get<std::array<double, 3>>();
    const auto q = order.at("orientation_wxyz").get<std::array<double, 4>>();
    return Pose{{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
}

/// A direction, of any length that has one.
std::optional<glm::dvec3> gaze_in(const json& order) {
    if (!order.contains("gaze"))
        return std::nullopt;
    const auto g = order.at("gaze").get<std::array<double, 3>>();
    const glm::dvec3 gaze(g[0], g[1], g[2]);
    const double length = glm::length(gaze);
    if (!(length > 1e-6 && length < 1e6))
        throw WorkError(expected_found("standard input", "a gaze vector 1e-6 to 1e6 long", order.at("gaze").dump()));
    return gaze / length;
}

bool is_sample_count(std::int64_t spp) {
    return spp >= 1 && spp <= max_samples;
}

/// What a pose may be is checked where the frame begins.
Order parse_order(const std::string& line, std::int64_t after) {
    Order order;
    try {
        const json parsed = json::parse(line);
        order.frame = parsed.at("frame").get<std::int64_t>();
        const auto spp = parsed.at("spp").get<std::int64_t>();
        const auto base_spp = parsed.value("base_spp", spp);
        const auto halvings = parsed.value("window_halvings", std::int64_t{0});
        if (order.frame > after && order.frame <= max_frame_index && is_sample_count(spp) &&
            is_sample_count(base_spp) && halvings >= 0 && halvings <= most_window_halvings) {
            order.spp = static_cast<std::uint32_t>(spp);
            order.base_spp = static_cast<std::uint32_t>(base_spp);
            order.halvings = static_cast<std::size_t>(halvings);
            order.head = pose_in(parsed);
            order.gaze = gaze_in(parsed);
            return order;
        }
    } catch (const json::exception&) {  // said below
    }
    throw WorkError(expected_found("standard input",
                                   "a line {\"frame\": above " + std::to_string(after) +
                                       ", \"spp\": N, \"position_m\": [x, y, z], \"orientation_wxyz\": [w, x, y, z]}",
                                   "'" + line + "'"));
}

void answer(const json& line) {
    std::printf("%s\n", json_text(line).c_str());
    if (std::fflush(stdout) != 0)
        throw WorkError("standard output: could not be written");
}

class Follower {
public:
    Follower(const FollowJob& job, RenderHost& host) : job_(job), host_(host), input_(STDIN_FILENO, job.interrupted) {
        for (const WindowGrid& grid : window_grids(job.options)) {
            densities_.push_back(std::make_unique<Density>(Density{job.options, {}, {}}));
            densities_.back()->options.window->grid = grid;
            if (densities_.size() > 1)
                densities_.back()->options.out /= "halved-" + std::to_string(densities_.size() - 1);
            densities_.back()->place.emplace(densities_.back()->options);
        }
    }

    void run() {
        answer({{"frames_per_second", job_.timeline.frames_per_second}});
        for (std::int64_t last = -1; const auto line = input_.next();) {
            const Order order = parse_order(*line, last);
            last = order.frame;
            if (!make(order))
                return;
        }
    }

private:
    bool accumulates() const { return job_.options.accumulate > 0; }
    /// A window that moves does not.
    bool window_accumulates() const { return accumulates() && !job_.options.window->follows_gaze; }

    using Streams = std::map<std::uint32_t, Stream>;  ///< by their samples; 0: those that are accumulated

    /// A density of the window's.
    struct Density {
        RenderOptions options;  ///< the job's, with its own grid and folder
        std::optional<HeadsWindow> place;
        Streams streams;
    };

    /// A sequence of independent frames has one number of samples: each number gets its own.
    template <typename Open>
    const Stream& stream_of(Streams& streams, const RenderOptions& all, std::uint32_t spp, bool independent,
                            Open open) {
        const std::uint32_t key = independent ? spp : 0;
        if (const auto found = streams.find(key); found != streams.end())
            return found->second;
        RenderOptions options = all;
        options.spp = spp;
        if (independent)
            options.out /= "spp-" + std::to_string(spp);
        const StreamOpener opener(options, job_.scene, job_.timeline.path, job_.record);
        return streams.emplace(key, open(opener)).first->second;
    }
    const Stream& window_of(Density& density, std::uint32_t spp) {
        return stream_of(density.streams, density.options, spp, !window_accumulates(),
                         [](const StreamOpener& opener) { return opener.window(); });
    }
    const Stream& sphere_of(std::uint32_t spp) {
        return stream_of(spheres_, job_.options, spp, !accumulates(),
                         [this](const StreamOpener& opener) { return opener.sphere(job_.options.eyes.front()); });
    }

    FrameTask task_of(const Order& order, double time_s) {
        FrameTask task;
        task.index = order.frame;
        task.head = order.head.value_or(job_.timeline.path.at(time_s));
        task.head_previous = last_ ? last_->head : task.head;
        task.head_next = task.head;
        task.previous_frames = last_ ? static_cast<std::uint32_t>(order.frame - last_->frame) : 1;
        task.stop = &stop_;
        task.paths_traced = [this](std::uint64_t) { stop_ = stop_ || input_.has_ended(); };
        return task;
    }

    /// False: it was told to stop in the middle.
    bool make(const Order& order) {
        const double time_s = job_.timeline.time_s(order.frame);
        FrameTask task = task_of(order, time_s);
        host_.move_to({order.frame, last_ ? job_.timeline.time_s(last_->frame) : time_s, time_s, time_s});
        Answer made{{{"frame", order.frame}}};
        const Stream* window = nullptr;
        if (!densities_.empty()) {  // before its base
            Density& density = *densities_[std::min(order.halvings, densities_.size() - 1)];
            window = &window_of(density, order.spp);
            task.spp = order.spp;
            task.window_place = density.place->at(task.head, order.gaze);
            if (!make(*window, {time_s}, task, made))
                return false;
            task.window_place = {};
        }
        task.spp = window ? order.base_spp : order.spp;
        if (!make(sphere_of(task.spp), {time_s, {}, window}, task, made))
            return false;
        last_ = Last{order.frame, task.head};
        made.line["render_s"] = made.render_s;
        made.line["write_s"] = made.write_s;
        answer(made.line);
        return true;
    }

    struct Answer {
        json line;
        double render_s = 0, write_s = 0;
    };

    /// One picture; false as above.
    bool make(const Stream& stream, const FrameContents& contents, FrameTask& task, Answer& made) {
        const auto start = Clock::now();
        task.stream = &stream.settings;
        FramePointer frame = begin_frame(stream, task, contents);
        task.frame = frame.get();
        host_.render(task);
        if (stop_)
            return false;
        made.render_s += seconds_since(start);
        const auto writing = Clock::now();
        end_frame(std::move(frame));
        made.write_s += seconds_since(writing);
        made.line[stream.settings.window ? "window" : "file"] = (stream.folder / frame_file_name(task.index)).string();
        return true;
    }

    const FollowJob& job_;
    RenderHost& host_;
    LineInput input_;
    std::atomic<bool> stop_ = false;
    Streams spheres_;
    std::vector<std::unique_ptr<Density>> densities_;  ///< by how often their pixels are halved; none without a window
    struct Last {
        std::int64_t frame;
        Pose head;
    };
    std::optional<Last> last_;  // frame that was answered
};

}  // namespace

void follow(const FollowJob& job, RenderHost& host) {
    const RenderOptions& options = job.options;
    if (options.eyes.size() > 1 || options.layers || options.patches || options.small_eye || options.frames)
        throw InputError(expected_found("--follow", "one eye, whose frames standard input asks for",
                                        options.eyes.size() > 1 ? "--eye both"
                                        : options.layers        ? "--layers"
                                        : options.patches       ? "--patches"
                                        : options.small_eye     ? "--small"
                                                                : "--frames"));
    Follower(job, host).run();
}

namespace {

/// A signal that comes just before the wait does not end it.
constexpr int longest_wait_ms = 500;

}  // namespace

std::optional<std::string> LineInput::next() {
    while (!interrupted_) {
        if (const auto end = read_.find('\n'); end != std::string::npos) {
            std::string line = read_.substr(0, end);
            read_.erase(0, end + 1);
            return line;
        }
        if (read_.size() > longest_line)
            throw WorkError(expected_found(
                "standard input", "lines of at most " + std::to_string(longest_line) + " bytes", "a longer one"));
        pollfd wait{descriptor_, POLLIN, 0};
        if (poll(&wait, 1, longest_wait_ms) <= 0)
            continue;
        char block[1024];
        const ssize_t count = ::read(descriptor_, block, sizeof block);
        if (count <= 0)
            return std::nullopt;
        read_.append(block, static_cast<std::size_t>(count));
    }
    return std::nullopt;
}

bool LineInput::has_ended() const {
    pollfd state{descriptor_, 0, 0};
    return interrupted_ || (poll(&state, 1, 0) > 0 && (state.revents & POLLHUP) != 0);
}

}  // namespace equistream::render_command
