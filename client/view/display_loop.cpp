#include "display_loop.h"

#include <client/transport/address.h>

#include <epoxy/gl.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <utility>

namespace equistream {

namespace {

/// While a source is opened, whose thread wakes who waits.
constexpr double opening_rest_s = 0.1;

}  // namespace

DisplayLoop::DisplayLoop(const ViewerSettings& settings, InputBox& box, Window& window)
    : settings_(settings), box_(box), window_(window),
      headset_(settings.headset ? std::make_unique<Headset>() : nullptr), shown_(settings.shown), kept_(settings.kept) {
    if (headset_)
        window_.do_not_wait_for_refreshes();  // the headset has its own
}

bool DisplayLoop::is_over() const {
    const bool is_late = began_ && settings_.seconds > 0 && seconds_since(*began_) >= settings_.seconds;
    return quit_ || is_late || inputs_.is_closed || (presenter_ != nullptr && presenter_->is_over());
}

void DisplayLoop::run() {
    if (settings_.source.empty())
        began_ = Clock::now();
    else
        open(settings_);
    while (!is_over()) {
        take_inputs();
        if (opening_ && opening_->is_done())
            finish_opening();
        if (presenter_ == nullptr) {
            draw_without_picture();
            continue;
        }
        presenter_->know_of(opening_ ? opening_->name() : "", kept_.recent);
        presenter_->refresh(inputs_, opening_ ? opening_rest_s : Face::awake_s);
        inputs_.forget();
        keep_changes();
        ask_for_more();
    }
}

ViewerReport DisplayLoop::report() {
    return presenter_ == nullptr ? ViewerReport() : presenter_->report();
}

// Inputs.

void DisplayLoop::take_inputs() {
    box_.take(window_inputs_);
    if (window_inputs_.window.width > 0 && window_inputs_.window.height > 0)
        face_.resize(window_inputs_.window, window_inputs_.scale);
    router_.route(window_inputs_, face_, inputs_);
    if (auto dropped = std::exchange(inputs_.dropped, std::nullopt))
        open_other(*dropped);
    grant_wishes();
    if (presenter_ == nullptr)
        act_without_picture();
}

/// What else is pressed waits for the picture.
void DisplayLoop::act_without_picture() {
    std::erase_if(inputs_.pressed, [this](Action action) {
        switch (action) {
        case Action::quit:
            quit_ = true;
            return true;
        case Action::open:
            face_.ask_for_source();
            return true;
        case Action::help:
            face_.turn_help_page();
            return true;
        case Action::fullscreen:
            box_.ask_for_fullscreen_toggle();
            window_.wake();
            return true;
        default:
            return false;
        }
    });
}

void DisplayLoop::grant_wishes() {
    for (const FaceWish& wish : face_.take_wishes()) {
        inputs_.any = true;
        try {
            grant(wish);
        } catch (const std::exception& error) {
            if (presenter_ != nullptr)
                presenter_->tell(error.what());
        }
    }
}

void DisplayLoop::grant(const FaceWish& wish) {
    std::visit(Overloaded{[&](Action action) { inputs_.pressed.push_back(action); },
                          [&](const SettingWish& chosen) { choose(chosen); },
                          [&](const SeekWish& sought) {
                              if (presenter_ != nullptr)
                                  presenter_->seek(sought.time_s);
                          },
                          [&](const OpenWish& wanted) { open_other(wanted.source); }},
               wish);
}

/// Without a picture it is for the one that comes.
void DisplayLoop::choose(const SettingWish& chosen) {
    if (presenter_ != nullptr)
        return presenter_->choose(*chosen.setting, chosen.value);
    const ShownSettings before = shown_;
    chosen.setting->set(shown_, chosen.value);
    kept_.keep_changes(before, shown_);
    box_.ask_to_keep(kept_);
}

// Sources.

void DisplayLoop::open(ViewerSettings settings) {
    opening_.reset();  // of two that are wanted at once, the last
    opening_ = std::make_unique<SourceOpening>(settings, [this] {
        box_.wake();
        window_.wake();
    });
}

/// What belongs to the source of the command line stays with it.
void DisplayLoop::open_other(const std::string& source) {
    ViewerSettings settings = settings_;
    settings.source = source;
    settings.shown = shown_;
    settings.paused = settings_.source.empty() && settings_.paused;
    settings.requires_hdr = false;
    if (!settings_.source.empty() && KeptSettings::name_of(source) != KeptSettings::name_of(settings_.source)) {
        settings.scene.reset();
        settings.truth.clear();
    }
    resumes_ = is_first_ = false;
    may_reopen_ = true;
    open(std::move(settings));
}

void DisplayLoop::finish_opening() {
    const std::unique_ptr<SourceOpening> opening = std::move(opening_);
    try {
        show(opening->take());
    } catch (const std::exception& error) {
        if (presenter_ == nullptr && is_first_)
            throw;
        may_reopen_ = false;
        if (presenter_ != nullptr)
            presenter_->tell(error.what());
        else
            problem_ = error.what();
        inputs_.any = true;
    }
}

void DisplayLoop::show(std::unique_ptr<WatchedSource> source) {
    ShownSettings shown = shown_;
    if (!source->settings.scene)
        shown.by_geometry = false;
    else if (source_ && !source_->settings.scene)
        shown.by_geometry = settings_.shown.by_geometry;  // the command line's source is there again
    auto presenter = std::make_unique<Presenter>(
        *source, shown, Presenter::Place{.box = box_, .window = window_, .face = face_, .headset = headset_.get()});
    const bool goes_on = std::exchange(resumes_, false) && presenter_ != nullptr;
    if (goes_on)
        presenter->go_on_from(*presenter_);
    shown_ = shown;
    presenter_ = std::move(presenter);
    source_ = std::move(source);
    if (settings_.source.empty())
        settings_.source = source_->settings.source;
    if (!began_)
        began_ = Clock::now();
    box_.ask_for_title("equistream: " + without_secrets(source_->settings.source));
    if (!source_->note.empty() && !goes_on)
        presenter_->tell(source_->note);
    kept_.remember(source_->settings.source);
    box_.ask_to_keep(kept_);
    inputs_.any = true;
}

void DisplayLoop::draw_without_picture() {
    const bool is_seen = inputs_.window.width > 0 && inputs_.window.height > 0;
    if (is_seen && (inputs_.any || !is_drawn_ || !face_.content().loading.empty() != (opening_ != nullptr))) {
        FaceContent content;
        content.loading = opening_ ? opening_->name() : "";
        content.warning = opening_ ? "" : problem_;
        is_drawn_ = true;
        content.shown = shown_;
        content.recent = kept_.recent;
        face_.say(std::move(content));
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        glClearColor(0, 0, 0, 1);
        glClear(GL_COLOR_BUFFER_BIT);
        face_.draw();
        window_.show();
    }
    if (!opening_)
        inputs_.forget();  // nothing that turns or moves waits for a picture that nobody asked for
    inputs_.any = false;
    box_.wait(opening_rest_s);
}

// Settings.

void DisplayLoop::keep_changes() {
    if (presenter_->shown() == shown_)
        return;
    kept_.keep_changes(shown_, presenter_->shown());
    shown_ = presenter_->shown();
    may_reopen_ = true;
    box_.ask_to_keep(kept_);
}

/// What was not decoded because nothing needed it is read from the same place on.
void DisplayLoop::ask_for_more() {
    if (opening_ || !may_reopen_ || !needs_reopening(source_->settings, shown_))
        return;
    if (!source_->loader.can_jump() && !source_->loader.is_live()) {
        may_reopen_ = false;
        return presenter_->tell(
            "this needs tracks that were not decoded, and a pipe is read once: reopen it with this setting");
    }
    ViewerSettings settings = source_->settings;
    settings.shown = shown_;
    resumes_ = true;
    open(std::move(settings));
}

}  // namespace equistream
