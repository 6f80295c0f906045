#pragma once
/// Frame after frame, resuming; while one is rendered the one before it is written.
#include "frame_patches.h"
#include "report.h"
#include "stream.h"

#include "host.h"

#include <future>
#include <optional>

namespace equistream::render_command {

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
    /// Throws WorkError when it is interrupted; whole frames stay.
    void run();

private:
    std::int64_t frames_in_all() const;
    std::uint64_t count_paths();
    void require_uninterrupted() const;
    void render_index(std::int64_t index);
    void render_frame(const Stream& stream, std::int64_t index);
    std::vector<PatchAtlas::Slot> plan(const Stream& stream, const FrameTask& task);
    void start_writing();
    void finish_writing();

    const SequenceJob job_;
    RenderHost& host_;
    RenderReport& report_;
    std::optional<FramePatches> patches_;
    std::atomic<std::uint64_t> paths_ = 0;
    cli::Progress progress_;
    FramePointer rendered_;  // filled, not yet being written
    std::optional<std::future<void>> writing_;
    std::string note_;  // of the frame that is written next
};

}  // namespace equistream::render_command
