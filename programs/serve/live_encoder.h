#pragma once
/// Rendered frames to the bytes of a live stream: Matroska, a cluster a frame, main and its depth. One thread at a
/// time.
#include <equistream/colour.h>
#include <equistream/depth_code.h>
#include <equistream/stream.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

namespace equistream::serve {

struct LiveCoding {
    double crf = StreamSettings{}.crf;
    std::string preset = "veryfast";
    bool depth = true;
    std::string out;  ///< a file that gets the same bytes; empty: none
};

class LiveEncoder {
public:
    explicit LiveEncoder(const LiveCoding& coding) : coding_(coding) {}

    struct Coded {
        std::string header;  ///< of the stream, with the first frame alone
        std::string bytes;
        bool begins_group = false;  ///< whoever has the header can begin here
    };
    /// Reads a frame and removes its file. A group begins with it if it is asked to, and at least once a second. Throws
    /// WorkError or InputError.
    Coded encode(const std::string& file, bool begin_group);
    /// What ends the stream; nothing where there was no frame.
    std::string finish();

private:
    void open(const Frame& frame);
    bool needs_group(const FrameInfo& info, double nearest_m) const;
    DepthRange range_before(double nearest_m) const;

    LiveCoding coding_;
    DisplayTransform display_;
    std::string taken_;  // bytes that were written; outlives the writer
    std::unique_ptr<StreamWriter> writer_;
    std::unique_ptr<DepthCode> depth_code_;  // null: no depth
    double box_radius_m_ = 0;
    DepthRange range_;  // of the group
    std::optional<double> group_start_s_;
};

}  // namespace equistream::serve
