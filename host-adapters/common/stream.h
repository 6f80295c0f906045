#pragma once
/// The sequences one render writes, opened through the C ABI: a sub-folder per eye, and the small stream.
#include "host.h"

#include <plugin/patches/planner.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::render_command {

struct CloseSequence {
    void operator()(es_sequence* sequence) const { es_sequence_close(sequence); }
};
struct DiscardFrame {
    void operator()(es_frame* frame) const { es_frame_discard(frame); }
};
using SequencePointer = std::unique_ptr<es_sequence, CloseSequence>;
using FramePointer = std::unique_ptr<es_frame, DiscardFrame>;

struct Stream {
    StreamSettings settings;
    SequencePointer sequence;
    std::filesystem::path folder;  ///< of its frames
};

/// Who renders, and what was typed.
struct RenderRecord {
    HostRecord host;
    int tile_side = 0;
    std::string command;
    HostNames names{};
};

/// Opens (or resumes) what a render writes. Each throws InputError or WorkError with the plugin's words.
class StreamOpener {
public:
    /// All is borrowed.
    StreamOpener(const RenderOptions& options, const SceneDescription& scene, const PosePath& path,
                 const RenderRecord& record);

    Stream window() const;  ///< `options` have one
    /// Of one eye; the base, where there is a window.
    Stream sphere(es_eye eye) const;
    /// Throws InputError where there are frames of another render beside them, which would be taken for their layers.
    std::vector<Stream> all() const;

private:
    Stream open(StreamSettings stream, std::uint32_t accumulated) const;
    bool writes(std::string_view folder) const;
    es_eye main_eye() const;
    void require_companions() const;

    const RenderOptions& options_;
    const SceneDescription& scene_;
    const PosePath& path_;
    const RenderRecord& record_;
    std::string fingerprint_;
};

struct FrameContents {
    double time_s = 0;
    std::span<const PatchAtlas::Slot> slots{};  ///< of a stream of patches
    const Stream* window = nullptr;             ///< of a base: the stream of its windows
};

/// A frame of one stream, poses of its neighbours included.
FramePointer begin_frame(const Stream& stream, const FrameTask& task, const FrameContents& contents);

/// Writes the frame.
void end_frame(FramePointer frame);

// Which patches each frame of a render shows: planned with the host's own rays, so that any host will do, and with the
// frame before, so that blocks keep their slots. Where that one was not rendered now it is read from its file: a
// render that was interrupted goes on with the same slots.

/// What the planner is asked for. Throws InputError where there is no head box to plan for.
PatchSettings patch_settings(const RenderOptions& options, double head_radius_m);

class FramePatches {
public:
    FramePatches(const RenderOptions& options, double head_radius_m);

    /// The host has been moved to the frame's time.
    PatchPlan plan(RenderHost& host, const FrameTask& task);

private:
    std::optional<PatchAtlas> atlas_before(std::int64_t index) const;

    const RenderOptions& options_;
    PatchSettings settings_;
    std::int64_t last_index_ = -1;
    std::optional<PatchAtlas> last_;
};

/// Where the window is of one head after the other: around its gaze, or where it stays.
class HeadsWindow {
public:
    /// `options` have a window; borrowed.
    explicit HeadsWindow(const RenderOptions& options);

    /// `gaze`: where eyes look, in the world; nothing: straight ahead of the head.
    WindowPlace at(const Pose& head, const std::optional<glm::dvec3>& gaze = {});

private:
    const RenderOptions& options_;
    WindowFollower follower_;
};

// Where each frame's window is: the path alone decides, so that a render that goes on puts it where it would have been.

class WindowPlaces {
public:
    /// `options` have a window; both are borrowed.
    WindowPlaces(const RenderOptions& options, const Timeline& timeline) : timeline_(timeline), window_(options) {}

    WindowPlace at(std::int64_t index);

private:
    const Timeline& timeline_;
    HeadsWindow window_;
    std::vector<WindowPlace> followed_;  ///< from the path's first frame on
};

}  // namespace equistream::render_command
