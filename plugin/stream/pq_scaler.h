#pragma once
/// HDR videos of others, whose samples lie otherwise than ours: in other places, of more or fewer of chroma, in other
/// ranges.
#include "libav.h"

namespace equistream {

/// PQ by BT.2020, of even sides, however its samples lie.
bool is_pq(const AVFrame& frame);

class PqScaler {
public:
    /// As equistream/pq.h describes, by swscale. `pq` is_pq().
    av::Frame as_ours(const AVFrame& pq);

private:
    struct Format {
        int width = 0, height = 0, pixel_format = -1, range = -1, chroma_location = -1;
        bool operator==(const Format&) const = default;
    };
    void prepare(const Format& format);

    Format format_;
    av::Scaler scaler_;
};

}  // namespace equistream
