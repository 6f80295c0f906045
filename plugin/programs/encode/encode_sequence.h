#pragma once
/// EXR sequences through the display transform into a stream.
#include "sources.h"

#include <equistream/stream.h>

#include <functional>

namespace equistream {

struct EncodeRequest {
    Sources sources;
    std::string target;
    StreamSettings settings;  ///< tracks, frame rate, scene, sphere and length are filled from the frames
};

struct EncodedTrack {
    TrackSettings settings;
    std::filesystem::path folder;
    std::int64_t bytes = 0;
};

struct EncodeReport {
    std::vector<EncodedTrack> tracks;
    StreamSettings settings;
    bool sphere_tag = false;  ///< as the container holds it
    FrameInfo first;          ///< the main track's first frame
    std::int64_t not_finite_samples = 0;
    double read_ms = 0;  ///< sums over all pictures
    double display_ms = 0;
    double encode_ms = 0;
    double wall_ms = 0;
};

/// `progress` is told the number of frames done.
EncodeReport encode_sequence(const EncodeRequest& request, const std::function<void(std::size_t)>& progress);

}  // namespace equistream
