#include "viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <client/pipeline/decisions.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <exception>
#include <thread>
#include <utility>

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

bool goes_on_by_repeats(Action action) {
    constexpr std::array repeated = {Action::frame_back, Action::frame_on,    Action::second_back, Action::second_on,
                                     Action::split_left, Action::split_right, Action::darker,      Action::brighter};
    return std::ranges::find(repeated, action) != repeated.end();
}

/// Of what the viewer may come to show: the depth of frames is of use to all engines but those that never move.
PipelineChoice widest_choice(const ViewerSettings& settings) {
    return {.engine = settings.scene ? "eye-depth" : settings.finding_engine,
            .depth = settings.scene ? "gl" : "stream",
            .fill = settings.fill_chain,
            .mirrors = settings.mirrors != MirrorTreatment::surface};
}

}  // namespace

Viewer::Viewer(const ViewerSettings& settings)
    : pictures_(settings.upload == PictureUpload::copied ? nullptr : std::make_shared<gl::PictureBuffers>()),
      loader_(settings.source, {.depth = true,
                                .hardware = settings.hardware,
                                .memory = pictures_,
                                .yuv = true,
                                .pq = true,
                                .hdr_display = settings.hdr_display,
                                .specular = settings.mirrors != MirrorTreatment::surface,
                                .left_out = [unused = unneeded_roles(widest_choice(settings))] { return unused; },
                                .poses = &poses_}) {
    if (!settings.truth.empty())
        truth_.emplace(settings.truth);
    const gl::Size size = truth_ ? gl::Size{truth_->camera().width, truth_->camera().height} : default_window_size;
    window_ = Window::open("equistream: " + settings.source, settings.size.value_or(size));
    observe();
    presenter_ = std::make_unique<Presenter>(settings, truth_ ? &*truth_ : nullptr, loader_, poses_, box_, *window_);
    // Until somebody reads there, the buffers stay empty and decoders keep to memory of their own.
    if (settings.upload == PictureUpload::mapped || !gl::Context::driver().is_software())
        presenter_->read_in_place(pictures_);
}

Viewer::~Viewer() {
    window_->make_current();  // for what is mapped, when nobody reads the source any more
}

ViewerReport Viewer::run() {
    ViewerReport report;
    std::exception_ptr failure;
    hear_signals();
    window_->release();
    std::thread display([&] {
        try {
            window_->make_current();
            presenter_->run();
            report = presenter_->report();
            report.mapped_bytes = pictures_ ? pictures_->bytes() : 0;
        } catch (...) {
            failure = std::current_exception();
        }
        presenter_.reset();
        window_->release();
        box_.end();
        window_->wake();
    });
    while (!box_.is_over()) {
        window_->wait(longest_wait_s);
        observe();
        if (box_.take_fullscreen_toggle())
            window_->toggle_fullscreen();
    }
    display.join();
    if (failure)
        std::rethrow_exception(failure);
    return report;
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
    const Inputs inputs = window_->take_inputs();
    seen_.samples.clear();
    seen_.pressed.clear();
    std::erase_if(chords_, [this](int key) { return !window_->is_down(key); });
    for (const KeyPress& press : inputs.pressed)
        if (press.modifiers != 0 && !press.repeated)
            chords_.push_back(press.key);
    for (const KeyPress& press : inputs.pressed)
        if (const KeyBinding* binding = binding_of(press.key, press.modifiers);
            binding != nullptr && !is_held(binding->action) && (!press.repeated || goes_on_by_repeats(binding->action)))
            seen_.pressed.push_back(binding->action);
    const bool steers = held_ != held() || !(sticks_ == window_->sticks()) || inputs.drag_x != 0 || inputs.drag_y != 0;
    held_ = held();
    sticks_ = window_->sticks();
    if (steers)
        seen_.samples.push_back({loader_.now_s(), held_, sticks_, inputs.drag_x, inputs.drag_y});
    const gl::Size size = window_->size();
    const bool resized = !(std::exchange(size_, size) == size);
    seen_.scroll = inputs.scroll;
    seen_.click_x = inputs.click_x;
    seen_.window = size;
    seen_.is_closed = window_->should_close() || told_to_end;
    seen_.any = steers || resized || inputs.is_damaged || !seen_.pressed.empty() || inputs.scroll != 0 ||
                inputs.click_x >= 0 || seen_.is_closed;
    if (seen_.any)
        box_.put(seen_);
}

}  // namespace equistream
