#include "program.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/json_text.h>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <utility>

namespace equistream::cli {

namespace {

std::string clock_text(double seconds) {
    const auto whole = static_cast<long>(std::lround(seconds));
    char text[32];
    if (whole >= 3600)
        std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
    else
        std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
    return text;
}

}  // namespace

ProgressStyle parse_progress(const std::string& text) {
    if (text == "auto")
        return ProgressStyle::automatic;
    if (text == "json")
        return ProgressStyle::json;
    if (text == "none")
        return ProgressStyle::none;
    throw InputError(expected_found("--progress", "auto, json or none", "'" + text + "'"));
}

struct Progress::State {
    std::mutex mutex;
    std::string what;
    double total;
    bool bar;
    bool json;
    bool drawn = false;
    Clock::time_point start = Clock::now();
    double last_drawn_s = -1;

    double seconds_left(double done) const {
        const double fraction = total > 0 ? done / total : 1;
        return fraction > 0 ? seconds_since(start) * (1 - fraction) / fraction : 0;
    }

    void draw(double done) {
        constexpr int width = 30;
        const double fraction = total > 0 ? std::clamp(done / total, 0.0, 1.0) : 1;
        const int filled = static_cast<int>(fraction * width);
        const std::string left = done > 0 ? clock_text(seconds_left(done)) + " left" : "";
        std::fprintf(stderr, "\r%s [%s%s] %3.0f%% %s   ", what.c_str(),
                     std::string(static_cast<std::size_t>(filled), '#').c_str(),
                     std::string(static_cast<std::size_t>(width - filled), '.').c_str(), 100 * fraction, left.c_str());
        std::fflush(stderr);
        drawn = true;
    }
};

Progress::Progress(std::string what, double total, ProgressStyle style) : state_(std::make_unique<State>()) {
    state_->what = std::move(what);
    state_->total = total;
    state_->bar = style == ProgressStyle::automatic && isatty(STDERR_FILENO) != 0;
    state_->json = style == ProgressStyle::json;
}

Progress::~Progress() {
    if (state_->drawn)
        std::fputc('\n', stderr);
}

void Progress::set(double done) {
    if (!state_->bar)
        return;
    const std::lock_guard lock(state_->mutex);
    const double now = seconds_since(state_->start);
    if (now - state_->last_drawn_s < 0.1)
        return;
    state_->last_drawn_s = now;
    state_->draw(done);
}

void Progress::step(double done, const std::string& note) {
    const std::lock_guard lock(state_->mutex);
    if (state_->bar)
        state_->draw(done);
    if (!state_->json)
        return;
    const nlohmann::json line = {{"what", state_->what},
                                 {"done", done},
                                 {"total", state_->total},
                                 {"note", note},
                                 {"seconds", seconds_since(state_->start)},
                                 {"seconds_left", state_->seconds_left(done)}};
    std::fprintf(stderr, "%s\n", json_text(line).c_str());
}

}  // namespace equistream::cli
