/// What the face says of what is shown.
#include "facts.h"
#include "presenter.h"

#include <client/gpu/memory.h>
#include <client/transport/address.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace equistream {

namespace {

/// Figures that change faster are not read.
constexpr double between_facts_s = 0.25;
/// A pixel is read so often at most.
constexpr double between_pixels_s = 0.1;

void append(std::vector<Fact>& facts, std::vector<Fact> more) {
    std::ranges::move(more, std::back_inserter(facts));
}

}  // namespace

FaceContent Presenter::make_content() {
    const FrameInfo& info = frame().main.info;
    FaceContent content;
    content.has_picture = true;
    content.warning = warning();
    content.status = status();
    content.timeline = {.first_s = loader_.first().time_s,
                        .seconds = source_.seconds(),
                        .frames_per_second = loader_.first().frames_per_second};
    content.time_s = info.time_s;
    content.frame = info.index;
    content.fraction_done = playback_.fraction_done();
    content.is_live = playback_.is_live();
    content.is_paused = playback_.is_paused();
    content.shown = shown_;
    content.has_hdr = pq_display_ != nullptr;
    content.has_geometry = settings_.scene.has_value();
    content.records_view = recorder_->records_view();
    content.records_head = recorder_->records_head();
    content.knows_motion = !info.moving.empty();
    content.decoder = frame().main.decoder;
    content.loading = content_.loading;
    content.recent = content_.recent;
    const std::optional<gl::PixelValues> values = probe_.take();
    if (shown_.panel) {
        if (measured_s_ < 0 || now_s_ - measured_s_ >= between_facts_s) {
            facts_ = make_facts();
            measured_s_ = now_s_;
        }
        if (values && asked_eye_)
            mouse_facts_ = mouse_facts(*values, asked_eye_->camera, asked_eye_->pose, frame());
        content.facts = facts_;
        append(content.facts, mouse_facts_);
    }
    return content;
}

std::vector<Fact> Presenter::make_facts() {
    const LoaderFigures figures = loader_.figures();
    std::vector<Fact> facts = source_facts(without_secrets(settings_.source), source_, frame());
    append(facts, method_facts({.engine = engine_in_use(),
                                .by_geometry = renderer_->has_geometry(),
                                .has_depth = renderer_->has_depth(),
                                .is_extrapolated = renderer_->extrapolated_s() > 0},
                               frame()));
    append(facts, network_facts(playback_, figures,
                                {.bits_per_second = bits_.per_second(now_s_),
                                 .is_followed = followed_.is_followed(),
                                 .lateness = lateness()}));
    append(facts, speed_facts({.refreshes_per_second = refreshes_.per_second(now_s_),
                               .frames_per_second = frames_.per_second(now_s_),
                               .latency_s = latency_.seconds(),
                               .decode_ms = frame().main.decode_ms,
                               .gpu_bytes = gl::object_bytes(),
                               .mapped_bytes = source_.pictures ? source_.pictures->bytes() : 0}));
    return facts;
}

/// Of the eye's pixel under the pointer, while the panel shows it.
void Presenter::ask_for_pixel() {
    const std::optional<PointerEvent> pointer = shown_.panel ? face_.pointer_over_picture() : std::nullopt;
    const bool is_other = pointer && is_split() && pointer->x >= split_ * float(inputs_.window.width);
    if (!pointer || is_other || !eyes_ || probe_.is_waiting() || now_s_ - asked_s_ < between_pixels_s)
        return;
    const auto pixel =
        gl::shown_pixel(shown_.layout, inputs_.window, int(std::floor(pointer->x)), int(std::floor(pointer->y)));
    if (!pixel)
        return;
    asked_s_ = now_s_;
    asked_eye_ = (*eyes_)[std::size_t(pixel->eye)];
    probe_.ask(*pixel, targets_, renderer_->depth(),
               shown_.overlay == gl::Overlay::reliability ? renderer_->reliability() : 0);
}

}  // namespace equistream
