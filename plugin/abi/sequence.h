#pragma once
/// What an es_sequence handle holds.
#include "settings.h"

#include <equistream/frame.h>

#include <filesystem>

namespace equistream {

/// An open sequence. Frames share its ownership, so that closing a sequence early cannot leave them dangling.
class Sequence {
public:
    /// Makes or resumes the folder; throws InputError when it cannot be used or holds other frames.
    explicit Sequence(SequenceSettings settings);

    const Manifest& manifest() const { return settings_.manifest; }
    bool keeps_frame(std::int64_t index) const;
    /// Writes a finished frame; the first one of a new folder also gives the manifest its poses.
    void write(const Frame& frame);

private:
    void note_poses(const FrameInfo& first);
    void make_folder() const;
    void adopt_or_refuse();

    SequenceSettings settings_;
    std::vector<std::int64_t> outdated_;  // frames of other settings, to be overwritten
    bool manifest_lacks_poses_ = false;
};

}  // namespace equistream
