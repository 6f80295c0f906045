#pragma once
/// The sequences one render writes, opened through the C ABI: a sub-folder per eye, and the small stream.
#include "options.h"

#include <equistream_scene/scene.h>

#include <memory>
#include <string>
#include <vector>

namespace equistream::embree_host {

struct CloseSequence {
    void operator()(es_sequence* sequence) const { es_sequence_close(sequence); }
};
struct DiscardFrame {
    void operator()(es_frame* frame) const { es_frame_discard(frame); }
};
using SequencePointer = std::unique_ptr<es_sequence, CloseSequence>;
using FramePointer = std::unique_ptr<es_frame, DiscardFrame>;

struct Stream {
    std::string name;  ///< sub-folder
    SequencePointer sequence;
    std::uint64_t pixels = 0;
    bool wants_surfaces = true;
};

/// Opens (or resumes) all streams. Throws InputError or WorkError with the plugin's words.
std::vector<Stream> open_streams(const RenderOptions& options, const SceneDescription& scene, const PosePath& path,
                                 const std::string& command);

/// A frame of one stream, poses of its neighbours included; frames beyond the path's ends have none.
FramePointer begin_frame(const Stream& stream, const PosePath& path, std::int64_t index, std::int64_t path_frames,
                         double frames_per_second);

/// Writes the frame.
void end_frame(FramePointer frame);

}  // namespace equistream::embree_host
