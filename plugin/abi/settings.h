#pragma once
/// Checks what a host hands over, field by field; every complaint names the field, what was expected and what was
/// found.
#include <equistream/equistream.h>
#include <equistream/sequence_writer.h>

#include <vector>

namespace equistream {

/// How a sequence is rendered, which its files do not say.
struct TileSettings {
    bool hidden_layer = false;
    int tile_side = 0;
};

/// Throws InputError.
SequenceSettings checked_settings(const es_sequence_settings* settings);
/// Throws InputError.
TileSettings checked_tile_settings(const es_sequence_settings* settings);

struct FrameSettings {
    std::int64_t index = 0;
    double time_s = 0;
    Pose head_previous, head, head_next;
    std::vector<PatchAtlas::Slot> slots;  ///< of an atlas
};

/// Throws InputError.
FrameSettings checked_settings(const es_frame_settings* settings);

}  // namespace equistream
