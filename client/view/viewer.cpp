#include "viewer.h"

#include "display_loop.h"
#include "truth.h"

#include <client/transport/address.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace equistream {

namespace {

/// Gamepads send no events, and those of the window that the displaying thread's own traffic brought wake nobody.
constexpr double longest_wait_s = 0.008;

std::atomic<bool> told_to_end = false;
static_assert(std::atomic<bool>::is_always_lock_free);

/// As closing the window does; a second one ends the program where it is.
void end_in_order(int signal_number) {
    told_to_end = true;
    std::signal(signal_number, SIG_DFL);
}

/// But for those that whoever started the program has it ignore.
void hear_signals() {
    for (const int number : {SIGINT, SIGTERM})
        if (std::signal(number, end_in_order) == SIG_IGN)
            std::signal(number, SIG_IGN);
}

/// The truth's, where it is to be seen beside what is drawn.
gl::Size first_size(const ViewerSettings& settings) {
    if (settings.size || settings.truth.empty())
        return settings.size.value_or(default_window_size);
    const PerspectiveCamera camera = Truth(settings.truth).camera();
    return {camera.width, camera.height};
}

}  // namespace

Viewer::Viewer(const ViewerSettings& settings) : settings_(settings), kept_(settings.kept), written_(settings.kept) {
    const std::string title =
        settings.source.empty() ? "equistream" : "equistream: " + without_secrets(settings.source);
    const std::optional<DesktopPlace>& place = kept_.window;
    if (place && !settings.size && settings.truth.empty())
        window_ = Window::open(title, {place->width, place->height}, place);
    else
        window_ = Window::open(title, first_size(settings));
    if (settings.size || !settings.truth.empty())
        asked_size_ = window_->place();
    observe();
}

Viewer::~Viewer() = default;

ViewerReport Viewer::run() {
    ViewerReport report;
    std::exception_ptr failure;
    hear_signals();
    window_->release();
    std::thread display([&] {
        try {
            window_->make_current();
            DisplayLoop loop(settings_, box_, *window_);
            loop.run();
            report = loop.report();
        } catch (...) {
            failure = std::current_exception();
        }
        window_->release();
        box_.end();
        window_->wake();
    });
    while (!box_.is_over()) {
        window_->wait(longest_wait_s);
        observe();
        do_what_is_asked();
    }
    display.join();
    if (failure)
        std::rethrow_exception(failure);
    do_what_is_asked();
    write_kept();
    return report;
}

void Viewer::do_what_is_asked() {
    if (box_.take_fullscreen_toggle())
        window_->toggle_fullscreen();
    if (const auto title = box_.take_title())
        window_->set_title(*title);
    if (auto kept = box_.take_kept()) {
        kept_ = std::move(*kept);
        write_kept();
    }
}

/// What cannot be written is said once.
void Viewer::write_kept() {
    if (settings_.kept_in.empty() || !may_write_)
        return;
    try {
        // A size that was asked for is not kept, unless the window was resized since.
        const DesktopPlace place = window_->place();
        if (!asked_size_ || place.width != asked_size_->width || place.height != asked_size_->height)
            kept_.window = place;
        write_kept_settings(settings_.kept_in, kept_, std::exchange(written_, kept_));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "equistream view: settings were not saved: %s\n", error.what());
        may_write_ = false;
    }
}

HeldActions Viewer::held() const {
    HeldActions held;
    if (window_->is_down(GLFW_KEY_LEFT_SHIFT) || window_->is_down(GLFW_KEY_RIGHT_SHIFT))
        return held;
    for (const KeyBinding& binding : key_bindings())
        if (is_held(binding.action) && binding.modifiers == 0 && window_->is_down(binding.key) &&
            !std::ranges::count(chords_, binding.key))
            held.set(std::size_t(binding.action));
    return held;
}

/// Tells the displaying thread what happened, if anything did.
void Viewer::observe() {
    Inputs inputs = window_->take_inputs();
    std::erase_if(chords_, [this](int key) { return !window_->is_down(key); });
    for (const InputEvent& event : inputs.events)
        if (const auto* key = std::get_if<KeyEvent>(&event);
            key != nullptr && key->is_down && key->modifiers != 0 && !key->is_repeated)
            chords_.push_back(key->key);
    const bool steers = held_ != held() || !(sticks_ == window_->sticks()) || inputs.is_dragged;
    held_ = held();
    sticks_ = window_->sticks();
    seen_.events = std::move(inputs.events);
    if (steers)
        seen_.events.push_back(SteeringEvent{Clock::now(), held_, sticks_});
    const gl::Size size = window_->size();
    const bool resized = !(std::exchange(size_, size) == size);
    const double scale = window_->scale();
    const bool rescaled = std::exchange(scale_, scale) != scale;
    seen_.window = size;
    seen_.scale = scale;
    seen_.is_closed = window_->should_close() || told_to_end;
    seen_.any = resized || rescaled || inputs.is_damaged || !seen_.events.empty() || seen_.is_closed;
    if (seen_.any)
        box_.put(seen_);
}

}  // namespace equistream
