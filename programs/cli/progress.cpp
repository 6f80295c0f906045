#include "program.h"

#include <equistream/json_text.h>

#include <nlohmann/json.hpp>

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

namespace equistream::cli {

namespace {

std::string clock_text(double seconds) {
    const auto whole = static_cast<long>(std::lround(seconds));
    if (whole >= 3600)
        return formatted("%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
    return formatted("%ld:%02ld", whole / 60, whole % 60);
}

}  // namespace

std::string progress_line(const std::string& what, double fraction, const std::string& left, std::size_t columns) {
    constexpr std::size_t widest = 30, narrowest = 5;
    // As wide in each line: what is left of the one before is written over.
    const std::string numbers = formatted(" %3.0f%% %-14s", 100 * fraction, left.c_str());
    const std::size_t room = columns == 0 ? std::string::npos : columns - 1;  // the cursor stands behind it
    const std::size_t taken = what.size() + std::strlen(" []") + numbers.size();
    const std::size_t width = std::min(widest, room - std::min(room, taken));
    std::string line = what;
    if (width >= narrowest) {
        const auto filled = std::size_t(fraction * double(width));
        line += " [" + std::string(filled, '#') + std::string(width - filled, '.') + "]";
    }
    return (line + numbers).substr(0, room);
}

ProgressStyle parse_progress(const std::string& text) {
    return parse_word<ProgressStyle>("--progress", text, std::array{"auto", "json", "none"});
}

Progress::Progress(std::string what, double total, ProgressStyle style)
    : what_(std::move(what)), total_(total), is_bar_(style == ProgressStyle::automatic && isatty(STDERR_FILENO) != 0),
      is_json_(style == ProgressStyle::json) {}

Progress::~Progress() {
    if (is_drawn_)
        std::fputc('\n', stderr);
}

double Progress::seconds_left(double done) const {
    const double fraction = total_ > 0 ? done / total_ : 1;
    return fraction > 0 ? seconds_since(start_) * (1 - fraction) / fraction : 0;
}

void Progress::draw(double done) {
    const double fraction = total_ > 0 ? std::clamp(done / total_, 0.0, 1.0) : 1;
    const std::string left = done > 0 ? clock_text(seconds_left(done)) + " left" : "";
    winsize terminal{};
    ioctl(STDERR_FILENO, TIOCGWINSZ, &terminal);
    std::fprintf(stderr, "\r%s", progress_line(what_, fraction, left, terminal.ws_col).c_str());
    std::fflush(stderr);
    is_drawn_ = true;
}

/// What is over at once is not drawn.
void Progress::draw_if_due(double done) {
    constexpr double shortest_s = 0.1;
    const double now = seconds_since(start_);
    if (!is_bar_ || (now - last_drawn_s_ < shortest_s && !(is_drawn_ && done >= total_)))
        return;
    last_drawn_s_ = now;
    draw(done);
}

void Progress::set(double done) {
    const std::lock_guard lock(mutex_);
    draw_if_due(done);
}

void Progress::step(double done, const std::string& note) {
    const std::lock_guard lock(mutex_);
    draw_if_due(done);
    if (!is_json_)
        return;
    const nlohmann::json line = {{"what", what_},
                                 {"done", done},
                                 {"total", total_},
                                 {"note", note},
                                 {"seconds", seconds_since(start_)},
                                 {"seconds_left", seconds_left(done)}};
    std::fprintf(stderr, "%s\n", json_text(line).c_str());
}

}  // namespace equistream::cli
