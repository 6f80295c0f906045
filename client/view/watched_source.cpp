#include "watched_source.h"

#include <client/pipeline/decisions.h>
#include <client/transport/address.h>
#include <equistream/send_times.h>

#include <filesystem>
#include <system_error>
#include <utility>

namespace equistream {

namespace {

/// Of what the viewer may come to show: the depth of frames is of use to all engines but those that never move.
PipelineChoice widest_choice(bool has_scene, const ShownSettings& shown) {
    const bool by_geometry = has_scene && shown.by_geometry;
    return {.engine = by_geometry ? "eye-depth" : shown.engine,
            .depth = by_geometry ? "gl" : "stream",
            .fill = shown.fill_chain,
            .mirrors = shown.mirrors != MirrorTreatment::surface || shown.overlay == gl::Overlay::reliability};
}

}  // namespace

WatchedSource::WatchedSource(const ViewerSettings& wanted, std::function<bool()> interrupted)
    : settings(wanted),
      pictures(wanted.upload == PictureUpload::copied ? nullptr : std::make_shared<gl::PictureBuffers>()),
      loader(wanted.source, {.depth = true,
                             .hardware = wanted.hardware,
                             .memory = pictures,
                             .yuv = true,
                             .pq = true,
                             .hdr_display = wanted.requires_hdr ? wanted.hdr_display : nullptr,
                             .specular = true,  // left out below where nothing asks for it
                             .left_out = [unused = unneeded_roles(widest_choice(wanted.scene.has_value(),
                                                                                wanted.shown))] { return unused; },
                             .interrupted = std::move(interrupted),
                             .poses = &poses}) {
    // As play: by other geometry parallax would be wrong, and nothing else would say so.
    if (wanted.scene && loader.is_posed())
        note = require_same_scene(loader.first(), without_secrets(wanted.source), *wanted.scene,
                                  wanted.scene->file.string())
                   .value_or("");
    if (!wanted.truth.empty())
        truth.emplace(wanted.truth);
    std::error_code error;
    if (!loader.seconds() && std::filesystem::is_regular_file(wanted.source, error))
        length_.emplace(wanted.source, 1 / loader.first().frames_per_second);
}

double WatchedSource::seconds() const {
    const double found_s = length_ ? length_->seconds() : 0;
    return found_s > 0 ? found_s : loader.seconds().value_or(0);
}

LengthFinder::LengthFinder(const std::string& file, double frame_s)
    : thread_([this, file, frame_s] {
          try {
              const double until_last_s = read_send_times(file, [this] { return stopping_.load(); }).longest_track_s;
              if (!stopping_)
                  seconds_ = until_last_s + frame_s;
          } catch (const std::exception&) {
              // Then it is not known.
          }
      }) {}

LengthFinder::~LengthFinder() {
    stopping_ = true;
    thread_.join();
}

bool needs_reopening(const ViewerSettings& opened, const ShownSettings& shown) {
    const bool has_scene = opened.scene.has_value();
    const PipelineChoice then = widest_choice(has_scene, opened.shown), now = widest_choice(has_scene, shown);
    return (unneeded_roles(then) & ~unneeded_roles(now)).any();
}

SourceOpening::SourceOpening(const ViewerSettings& settings, const std::function<void()>& done)
    : name_(without_secrets(settings.source)), thread_([this, settings, done] {
          try {
              source_ = std::make_unique<WatchedSource>(settings, [stopping = stopping_] { return stopping->load(); });
          } catch (...) {
              failure_ = std::current_exception();
          }
          done_ = true;
          done();
      }) {}

SourceOpening::~SourceOpening() {
    if (!thread_.joinable())
        return;
    *stopping_ = true;
    thread_.join();
}

std::unique_ptr<WatchedSource> SourceOpening::take() {
    thread_.join();
    if (failure_)
        std::rethrow_exception(std::exchange(failure_, nullptr));
    return std::move(source_);
}

}  // namespace equistream
