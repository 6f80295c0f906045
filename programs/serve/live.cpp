#include "live.h"

#include "children.h"
#include "programmes.h"
#include "rate.h"

#include <equistream/denoise_quality.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/stream.h>
#include <equistream/text.h>

#include <programs/cli/commands.h>
#include <programs/cli/paths.h>
#include <programs/cli/process.h>

#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/thread_pool.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace equistream::serve {

namespace {

constexpr double slowest = 0.01, quickest = 1000;
constexpr std::uint32_t max_samples = 1 << 20;
constexpr double max_mbps = 1e5;
constexpr const char* option_group = "For a scene, rendered while it is watched";

constexpr double note_interval_s = 10;

std::string words_of(const std::exception_ptr& problem) {
    try {
        std::rethrow_exception(problem);
    } catch (const std::exception& error) {
        return error.what();
    } catch (const cli::ChildFailed& failed) {  // it has said why
        return "the renderer ended with status " + std::to_string(failed.exit_code);
    }
}

/// For viewers to take what is left, once it ends.
constexpr std::chrono::seconds time_to_take_the_rest{2};

std::optional<double> bits(std::optional<double> megabits) {
    return megabits ? std::optional(1e6 * *megabits) : std::nullopt;
}

class Live {
public:
    Live(asio::io_context& io, asio::signal_set& stop, std::unique_ptr<Door> door, const LiveSettings& settings)
        : io_(io), stop_(stop), settings_(settings), stream_([this] { look_soon(); }),
          server_(io, std::move(door), stream_, settings.server), encoder_(settings.coding),
          pace_(settings.max_spp, settings.spheres_per_s, settings.has_window), rate_(bits(settings.max_mbps)),
          halvings_(settings.coding.crf), timer_(io) {
        start_renderer();
    }
    ~Live() {
        server_.stop();  // before what its viewers are fed from goes
        worker_.join();
    }
    Live(const Live&) = delete;
    Live& operator=(const Live&) = delete;

    LiveFigures run(std::function<void(const std::string&)> listening) {
        listening_ = std::move(listening);
        stop_.async_wait([this](const asio::error_code& error, int) {
            if (!error)
                end(nullptr);
        });
        io_.run();
        if (problem_)
            std::rethrow_exception(problem_);
        return figures();
    }

private:
    /// Of a sphere on its way to the encoder.
    struct Times {
        Clock::time_point ordered, rendered;
        double pose_age_s = 0;  // when it was ordered
    };

    void start_renderer() {
        is_ready_ = is_rendering_ = false;
        child_.emplace(io_, settings_.program, settings_.arguments,
                       RenderChild::Events{[this](double rate) { start(rate); },
                                           [this](const RenderedFrame& frame) { take(frame); },
                                           [this](std::exception_ptr problem) { lose_renderer(problem); }});
    }

    /// One that had loaded its scene is started again, a few times an hour.
    void lose_renderer(std::exception_ptr problem) {
        if (is_ending_ || !is_ready_ || !restarts_.allows(Clock::now()))
            return end(problem);
        note(words_of(problem) + "; restarting it");
        child_->end();
        asio::post(io_, [this] {  // not within its own call
            if (is_ending_)
                return;
            try {
                start_renderer();
            } catch (...) {
                end(std::current_exception());
            }
        });
    }

    /// Whoever tells of a change may be in the middle of it.
    void look_soon() {
        asio::post(io_, [this] { look(); });
    }

    void look() {
        if (is_ending_) {
            if (has_ended_ && server_.viewers() == 0)
                close();
            return;
        }
        if (stream_.viewers() == 0)
            was_idle_ = true;
        else if (is_ready_ && !is_rendering_ && coding_ <= 1)
            order_next();
    }

    void start(double frames_per_second) {
        frames_per_second_ = frames_per_second;
        is_ready_ = true;
        if (std::exchange(is_listening_, true)) {
            was_idle_ = true;  // time stood still
            return look();
        }
        server_.start();
        listening_(server_.web_url());
    }

    /// Scene time goes on with the clock while somebody watches, and stands while nobody does.
    void order_next() {
        const auto now = Clock::now();
        if (was_idle_) {
            rate_.pause();
            time_zero_ = now - in_clock(double(last_frame_ + 1) / frames_per_second_);
        }
        const double time_s = std::chrono::duration<double>(now - time_zero_).count();
        const auto frame = std::int64_t(std::floor(time_s * frames_per_second_ + 1e-6));
        if (frame <= last_frame_) {  // quicker than the scene's own frames
            timer_.expires_at(time_zero_ + in_clock(double(last_frame_ + 1) / frames_per_second_));
            timer_.async_wait([this](const asio::error_code& error) {
                if (!error)
                    look();
            });
            return;
        }
        if (!std::exchange(was_idle_, false)) {
            busy_s_ += seconds_since(ordered_);
            ++intervals_;
        }
        last_frame_ = frame;
        // A head at rest sends nothing: how long ago it said so is no delay.
        pose_age_s_ = stream_.steering_age_s();
        if (pose_age_s_ && *pose_age_s_ > seconds_since(ordered_))
            pose_age_s_.reset();
        ordered_ = now;
        is_rendering_ = true;
        // A window lies where eyes will look once it is on its way.
        const Samples samples = pace_.samples();
        int halvings = 0;
        if (settings_.has_window)
            halvings = halvings_.next(seconds_since(start_), rate_.coarser());
        child_->order(
            {frame, samples.looked_at, samples.base, halvings, stream_.steering(), stream_.gaze(last_age_s_)});
    }

    void take(const RenderedFrame& frame) {
        is_rendering_ = false;
        figures_.render_s += frame.render_s;
        figures_.write_s += frame.write_s;
        figures_.stages.add(LiveStage::render, seconds_since(ordered_) - frame.write_s);
        figures_.stages.add(LiveStage::hand_over, frame.write_s);
        if (pose_age_s_)
            figures_.stages.add(LiveStage::pose, *pose_age_s_);
        const Samples samples = pace_.samples();
        tell(pace_.took(seconds_since(ordered_)), samples, seconds_since(ordered_));
        ++coding_;
        asio::post(worker_, [this, frame, begin_group = stream_.take_group_wanted(), coarser = rate_.coarser(),
                             times = Times{ordered_, Clock::now(), pose_age_s_.value_or(0)}] {
            encode(frame, begin_group, coarser, times);
        });
        look();
    }

    /// In the worker's thread.
    void encode(const RenderedFrame& frame, bool begin_group, double coarser, const Times& times) {
        const auto start = Clock::now();
        try {
            auto coded = encoder_.encode(frame.file, frame.window, begin_group, coarser, seconds_since(start_));
            asio::post(io_, [this, coded = std::move(coded), start, took_s = seconds_since(start), times] {
                figures_.stages.add(LiveStage::wait, std::chrono::duration<double>(start - times.rendered).count());
                figures_.stages.add(LiveStage::encode, took_s);
                figures_.stages.add(LiveStage::all, times.pose_age_s + seconds_since(times.ordered));
                publish(coded, took_s, times.ordered);
            });
        } catch (...) {
            asio::post(io_, [this, problem = std::current_exception()] { end(problem); });
        }
    }

    void publish(const LiveEncoder::Coded& coded, double took_s, Clock::time_point ordered) {
        --coding_;
        ++figures_.spheres;
        figures_.encode_s += took_s;
        last_age_s_ = seconds_since(ordered);
        figures_.age_s += last_age_s_;
        if (!coded.header.empty())
            stream_.set_header(coded.header);
        adapt(coded);
        stream_.publish(coded.bytes, coded.begins_group);
        server_.wake();
        if (seconds_since(noted_) >= note_interval_s && intervals_ > 0) {
            noted_ = Clock::now();
            note(formatted("%.2f spheres/s with %s", double(intervals_) / busy_s_,
                           samples_text(pace_.samples()).c_str()));
        }
        look();
    }

    /// Before these bytes are sent: viewers had all the time since the last ones for those.
    void adapt(const LiveEncoder::Coded& coded) {
        const double now_s = seconds_since(start_);
        coded_bits_ += 8.0 * double(coded.bytes.size());
        rate_.coded(now_s, coded.bytes.size(), coded.coarser, coded.begins_group);
        if (const auto delivery = stream_.delivery())
            rate_.delivered(now_s, delivery->first, delivery->second);
        window_halvings_ = coded.window_halvings;
        const double asked_crf = settings_.coding.crf, coarser = std::min(rate_.coarser(), worst_crf - asked_crf);
        const bool is_coarser = said_quality_.first ? coarser > 0 : coarser >= 1;
        const std::pair quality(is_coarser, is_coarser ? window_halvings_ : 0);
        if (quality == said_quality_ || seconds_since(rate_noted_) < note_interval_s)
            return;
        said_quality_ = quality;
        rate_noted_ = Clock::now();
        if (!is_coarser)
            return note(formatted("the stream is back to CRF %g", asked_crf));
        const double limit_mbps = 1e-6 * rate_.limit_bps();
        const bool is_told = settings_.max_mbps && limit_mbps > 0.99 * *settings_.max_mbps;
        const std::string why = is_told ? formatted("to stay within --mbit %.3g:", limit_mbps)
                                        : formatted("the network to the viewer that %s takes %.3g Mbit/s:",
                                                    stream_.steering() ? "moves the camera" : "came first", limit_mbps);
        note(why + formatted(" CRF %.0f instead of %g", crf(), asked_crf) + window_text());
    }

    /// The window's, where there is one.
    double crf() const {
        const double steps = std::max(0.0, rate_.coarser() - steps_that_halve * window_halvings_);
        return std::min(settings_.coding.crf + steps, double(worst_crf));
    }
    std::string window_text() const {
        return window_halvings_ > 0 ? formatted(", and %.2g of the window's pixels", std::exp2(-window_halvings_)) : "";
    }

    void tell(Pace::Change change, const Samples& before, double sphere_s) const {
        const std::string rate = formatted("--rate %g", settings_.spheres_per_s);
        if (change == Pace::Change::fewer)
            note(formatted("a sphere takes %.2f s with %s: changing to %s, to keep up with %s", sphere_s,
                           samples_text(before).c_str(), samples_text(pace_.samples()).c_str(), rate.c_str()));
        else if (change == Pace::Change::cannot_keep_up)
            note(formatted("a sphere takes %.2f s even with 1 sample a pixel, too slow for %s: use a smaller --size",
                           sphere_s, rate.c_str()));
    }

    void note(const std::string& text) const { log_note(settings_.server.log, text); }

    /// At a signal, or at what cannot be gone on with. The worker ends what it has; then viewers get the stream's end.
    void end(std::exception_ptr problem) {
        if (!problem_)
            problem_ = problem;
        if (std::exchange(is_ending_, true))
            return;
        if (child_)  // where it could not be started again there is none
            child_->end();
        timer_.cancel();
        server_.stop_accepting();
        asio::post(worker_, [this] {
            std::string rest;
            try {
                rest = encoder_.finish();
            } catch (...) {
                asio::post(io_, [this, trouble = std::current_exception()] { end(trouble); });
            }
            asio::post(io_, [this, rest] { part(rest); });
        });
    }

    void part(const std::string& rest) {
        stream_.publish(rest, true);
        stream_.end();
        has_ended_ = true;
        server_.wake();
        timer_.expires_after(time_to_take_the_rest);
        timer_.async_wait([this](const asio::error_code& error) {
            if (!error)
                close();
        });
        look();
    }

    void close() {
        timer_.cancel();
        server_.stop();
        asio::error_code ignored;
        stop_.cancel(ignored);
    }

    LiveFigures figures() const {
        LiveFigures sums = figures_;
        const double count = double(std::max<std::int64_t>(1, sums.spheres));
        for (double* sum : {&sums.render_s, &sums.write_s, &sums.encode_s, &sums.age_s})
            *sum /= count;
        sums.spheres_per_s = busy_s_ > 0 ? double(intervals_) / busy_s_ : 0;
        sums.samples = pace_.samples();
        sums.crf = crf();
        sums.window_pixels = std::exp2(-window_halvings_);
        sums.coded_mbps = busy_s_ > 0 ? 1e-6 * coded_bits_ / busy_s_ : 0;
        sums.missed = stream_.spheres_missed();
        sums.poses = stream_.poses_heard();
        sums.server = server_.figures();
        return sums;
    }

    asio::io_context& io_;
    asio::signal_set& stop_;
    const LiveSettings& settings_;
    LiveStream stream_;
    Server server_;
    LiveEncoder encoder_;  // the worker's
    Pace pace_;
    RateControl rate_;
    WindowHalvings halvings_;
    asio::steady_timer timer_;
    LiveFigures figures_;  // sums
    std::function<void(const std::string&)> listening_;
    double frames_per_second_ = 30;
    Clock::time_point start_ = Clock::now(), time_zero_, ordered_, noted_ = start_, rate_noted_{};
    std::int64_t last_frame_ = -1;
    double busy_s_ = 0, coded_bits_ = 0;
    double last_age_s_ = 0;             // as in LiveFigures, of the last sphere
    std::optional<double> pose_age_s_;  // when the last sphere was ordered; nothing: no pose was new
    std::int64_t intervals_ = 0;
    int coding_ = 0;              // frames that the worker has not coded yet
    double window_halvings_ = 0;  // as last coded
    bool is_ready_ = false, is_rendering_ = false, was_idle_ = true, is_listening_ = false;
    bool is_ending_ = false, has_ended_ = false;
    std::pair<bool, double> said_quality_{false, 0};  // coarser, and how often the window's pixels were halved
    std::exception_ptr problem_;
    asio::thread_pool worker_{1};
    Restarts restarts_;
    std::optional<RenderChild> child_;  // last: it tells the others
};

}  // namespace

LiveFigures serve_live(asio::io_context& io, asio::signal_set& stop, std::unique_ptr<Door> door,
                       const LiveSettings& settings, const std::function<void(const std::string& web_url)>& listening) {
    return Live(io, stop, std::move(door), settings).run(listening);
}

bool is_scene(const std::string& source) {
    return source.ends_with(".json") || source.ends_with(".xml");
}

void add_live_options(cli::CommandLine& app, LiveOptions& o) {
    const auto add = [&](const char* name, auto& value, const std::string& text) {
        return app.add_option(name, value, text).group(option_group);
    };
    LiveSettings& s = o.settings;
    add("--host", o.host, "Renderer").with_default().offers(cli::hosts);
    add("--size", o.size, "Of the spheres, WxH").with_default();
    add("--window", o.window,
        "WxH degrees of a denser sphere (render --window), around the gaze of the viewer that moves the camera, else "
        "of the first viewer. Viewers who look nearly the same way count too");
    add("--density", o.density, "Columns of that denser sphere (default: four times those of --size)");
    add("--spp", s.max_spp, "Samples per pixel, at most: fewer where that keeps up with --rate").with_default();
    add("--denoise", o.denoise, "Take the noise out of each sphere, as render does")
        .one_of(denoise_quality_names)
        .with_default();
    add("--accumulate", o.accumulate, "Average light over spheres, as render --accumulate does")
        .between(0u, 1000u)
        .with_default();
    add("--rate", s.spheres_per_s, "Spheres a second to keep up with; more where there is time").with_default();
    add("--path", o.path, "Path (CSV) of the head until a viewer moves, instead of the scene's");
    add("--threads", o.threads, "Rendering threads (default: one per processor)");
    add("--depth", o.depth, "auto, or none: no track of depth").with_default().offers(std::array{"auto", "none"});
    add("--crf", s.coding.crf, "Quality: 0 (best) to 51; coarser while the network is too slow for it").with_default();
    add("--mbit", s.max_mbps, "Most megabits a second of the stream (default: as many as the network takes)");
    add("--preset", s.coding.preset, "The encoder's, as in encode").with_default();
    add("--out", s.coding.out, "File (.mkv) to write the stream to, as a viewer from the start receives it");
}

void require_live_options_unused(const cli::CommandLine& app, const std::string& source) {
    const bool is_folder = std::filesystem::is_directory(source);
    for (const cli::Option option : app.options()) {
        if (option.group() != option_group || !option.is_given())
            continue;
        const std::string name = option.name();
        throw InputError(
            expected_found(name + ": " + source, "a scene (.json, .xml) to render",
                           is_folder ? "a folder; options of encode follow --, such as -- --depth auto" : "none"));
    }
}

LiveSettings live_settings(const LiveOptions& options, const std::string& scene, const std::filesystem::path& folder,
                           const std::vector<std::string>& more) {
    LiveSettings settings = options.settings;
    const cli::Size size = cli::parse_size(options.size);
    cli::require(size.width % 2 == 0 && size.height % 2 == 0 && std::min(size.width, size.height) >= min_track_side,
                 "--size", "even sides of at least " + std::to_string(min_track_side), options.size);
    cli::require(settings.max_spp >= 1 && settings.max_spp <= max_samples, "--spp", "1 to 1048576",
                 std::to_string(settings.max_spp));
    cli::require(settings.spheres_per_s >= slowest && settings.spheres_per_s <= quickest, "--rate", "0.01 to 1000",
                 in_words(settings.spheres_per_s));
    cli::require(settings.max_mbps.value_or(1) > 0 && settings.max_mbps.value_or(1) <= max_mbps, "--mbit",
                 "above 0 and at most " + in_words(max_mbps), in_words(settings.max_mbps.value_or(0)));
    settings.coding.depth = cli::parse_word("--depth", options.depth, std::array{"auto", "none"}) == 0;
    const std::string& out = settings.coding.out;
    cli::require(out.empty() || (out.ends_with(".mkv") && !is_url(out)), "--out", "a file's name ending in .mkv",
                 "'" + out + "'");
    if (!out.empty()) {
        cli::require_writable_file(out);
        require_replaceable_stream(out);
    }
    for (const std::string& word : more)  // each order says how many
        for (const char* own : {"--spp", "--overwrite"})
            cli::require(word != own && !word.starts_with(own + std::string("=")), "-- " + word,
                         "an option of render that serve does not set itself", own);
    StreamSettings coding;
    coding.crf = settings.coding.crf;
    coding.preset = settings.coding.preset;
    check_coding(coding, "--");
    settings.has_window = !options.window.empty();
    settings.program = cli::host_program(options.host, cli::own_folder()).string();
    settings.arguments = {scene,        "--follow",   "--out",     (folder / "frames").string(),
                          "--size",     options.size, "--aovs",    settings.coding.depth ? "depth" : "none",
                          "--progress", "none",       "--denoise", options.denoise};
    if (!options.window.empty())
        settings.arguments.insert(settings.arguments.end(), {"--window", "gaze," + options.window});
    if (options.density)
        settings.arguments.insert(settings.arguments.end(), {"--density", std::to_string(*options.density)});
    if (!options.path.empty())
        settings.arguments.insert(settings.arguments.end(), {"--path", options.path});
    if (options.accumulate > 0)
        settings.arguments.insert(settings.arguments.end(), {"--accumulate", std::to_string(options.accumulate)});
    if (options.threads > 0)
        settings.arguments.insert(settings.arguments.end(), {"--threads", std::to_string(options.threads)});
    settings.arguments.insert(settings.arguments.end(), more.begin(), more.end());
    return settings;
}

}  // namespace equistream::serve
