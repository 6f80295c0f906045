#include "scaling.h"

extern "C" {
#include <libavutil/opt.h>
}

#include <cassert>
#include <new>

namespace equistream {

void set_scaling(SwsContext& scaler, const char* option, int value) {
    [[maybe_unused]] const int code = av_opt_set_int(&scaler, option, value, 0);
    assert(code >= 0);
}

av::Scaler make_scaler(int width, int height, int from_pixel_format, int to_pixel_format) {
    av::Scaler scaler(sws_alloc_context());
    if (!scaler)
        throw std::bad_alloc();
    for (const char* option : {"srcw", "dstw"})
        set_scaling(*scaler, option, width);
    for (const char* option : {"srch", "dsth"})
        set_scaling(*scaler, option, height);
    set_scaling(*scaler, "src_format", from_pixel_format);
    set_scaling(*scaler, "dst_format", to_pixel_format);
    set_scaling(*scaler, "sws_flags",
                SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP);
    return scaler;
}

}  // namespace equistream
