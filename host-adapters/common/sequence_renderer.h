#pragma once
/// What a render tells at its end.
#include "host.h"
#include "stream.h"

#include <cstdint>
#include <future>
#include <optional>
#include <string>

namespace equistream::render_command {

/// Sums over the frames whose patches were planned.
struct PatchReport {
    std::int64_t frames = 0;
    double pixel_share = 0;                 ///< of used slots, to the sphere's
    double covered = 0;                     ///< of what the planner's eyes uncover
    double used_slots = 0, kept_slots = 0;  ///< all; those as in the frame before
    double plan_s = 0;                      ///< part of render_s
};

/// Over all frames of the render, kept ones too.
struct WindowReport {
    WindowGrid grid;
    std::int64_t moves = 0;
};

struct RenderReport {
    std::int64_t frames_rendered = 0, frames_kept = 0;
    unsigned threads = 0;
    double load_s = 0;    ///< everything before the first frame
    double render_s = 0;  ///< frames, writing included
    std::uint64_t paths = 0;
    PatchReport patches;
    std::optional<WindowReport> window;
};

/// Text or JSON on standard output.
void print_report(const RenderReport& report, const RenderHost& host, const std::string& command, bool json);

/// What would be rendered: text or JSON on standard output. `farm` divides it.
void print_plan(const RenderOptions& options, const Timeline& timeline, const RenderHost& host,
                const std::string& command);

// Frame after frame, resuming; while one is rendered the one before it is written.

/// Borrowed for as long as the renderer lives.
struct SequenceJob {
    const RenderOptions& options;
    const Timeline& timeline;
    double head_radius_m = 0;  ///< the scene's head box
    const std::vector<Stream>& streams;
    const std::atomic<bool>& interrupted;
};

class SequenceRenderer {
public:
    SequenceRenderer(const SequenceJob& job, RenderHost& host, RenderReport& report);
    /// Throws WorkError when it is interrupted before the last frame is finished; whole frames stay.
    void run();

private:
    std::int64_t frames_in_all() const;
    /// By stream and frame of the range: whether it was finished before this render. Each file is looked at once.
    std::vector<std::vector<bool>> check_finished() const;
    bool was_finished(const Stream& stream, std::int64_t index) const;
    bool is_kept(const Stream& stream, std::int64_t index) const;
    void find_last_missing();
    std::uint64_t count_paths();
    std::uint64_t sampled_pixels(const StreamSettings& stream, std::int64_t index);
    void count_moves();
    const Stream* window_of(const Stream& base) const;
    void require_all_finished() const;
    void stop_if_interrupted();
    void render_index(std::int64_t index);
    void render_frame(const Stream& stream, std::int64_t index);
    std::vector<PatchAtlas::Slot> plan(const Stream& stream, const FrameTask& task);
    void start_writing();
    void finish_writing();
    void keep_if_finished();

    const SequenceJob job_;
    RenderHost& host_;
    RenderReport& report_;
    std::int64_t last_missing_ = -1;  ///< of the frames that are accumulated; below 0: none is
    std::int64_t rendered_again_ = 0;
    std::optional<FramePatches> patches_;
    std::optional<WindowPlaces> windows_;
    const std::vector<std::vector<bool>> finished_;
    std::atomic<std::uint64_t> paths_ = 0;
    cli::Progress progress_;
    FramePointer rendered_;  // filled, or stopped while it was; not yet being written
    std::optional<std::future<void>> writing_;
    std::string note_;  // of the frame that is written next
};

}  // namespace equistream::render_command
