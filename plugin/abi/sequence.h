#pragma once
/// What an es_sequence handle holds.
#include "settings.h"

#include <equistream/frame.h>
#include <equistream/locks.h>

#include <filesystem>

namespace equistream {

/// An open sequence. Frames share its ownership, so that closing a sequence early cannot leave them dangling.
class Sequence {
public:
    /// Makes or resumes the folder and holds it; throws InputError when it cannot be used, holds other frames or is
    /// held by another sequence.
    explicit Sequence(SequenceSettings settings);

    const Manifest& manifest() const { return settings_.manifest; }
    bool keeps_frame(std::int64_t index) const;
    /// Writes a finished frame; the manifest takes its poses from the one with the lowest index, whenever it comes.
    void write(const Frame& frame, std::int64_t left_out_samples);

private:
    void make_way_for(const FrameInfo& info);
    void set_first_frame(const FrameInfo& first);
    void make_folder() const;
    void adopt_or_refuse();

    SequenceSettings settings_;
    std::optional<FolderLock> lock_;      // two renders at once would mix their settings
    std::vector<std::int64_t> outdated_;  // frames of other settings, to be overwritten
    bool knows_first_frame_ = false;      // the manifest's index, time and poses are those of a frame in the folder
    bool manifest_is_current_ = false;    // the one in the folder is ours
};

}  // namespace equistream
