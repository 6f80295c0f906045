#pragma once
/// The sequences one render writes, opened through the C ABI: a sub-folder per eye, and the small stream.
#include "host.h"

#include <memory>
#include <string>
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
};

/// Who renders, and what was typed.
struct RenderRecord {
    HostRecord host;
    int tile_side = 0;
    std::string command;
};

/// Opens (or resumes) all streams. Throws InputError or WorkError with the plugin's words.
std::vector<Stream> open_streams(const RenderOptions& options, const SceneDescription& scene, const PosePath& path,
                                 const RenderRecord& record);

struct FrameContents {
    double time_s = 0;
    std::span<const PatchAtlas::Slot> slots{};  ///< of a stream of patches
};

/// A frame of one stream, poses of its neighbours included.
FramePointer begin_frame(const Stream& stream, const FrameTask& task, const FrameContents& contents);

/// Writes the frame.
void end_frame(FramePointer frame);

}  // namespace equistream::render_command
