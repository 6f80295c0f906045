#pragma once
/// Decoders that write their pictures into memory that was handed to them (libavcodec's direct rendering), and what
/// their callbacks know.
#include "libav.h"

#include <equistream/picture_memory.h>

namespace equistream {

/// What AVCodecContext::opaque points at; outlives the context.
struct DecoderCallbacks {
    AVPixelFormat hardware_format = AV_PIX_FMT_NONE;  ///< of pictures in a device's memory; none: there is no device
    std::shared_ptr<PictureMemory> memory;            ///< null: libavcodec's own
};

/// Before the decoder is opened, whose `opaque` says where to. Pictures of another kind than equistream/yuv.h and pq.h
/// describe, those of decoders that cannot, and those that there is no memory for lie where they always did.
void render_into_memory(AVCodecContext& codec);

/// An owning frame of that format and size in memory that was handed over, else in ordinary memory; null: there is
/// none.
av::Frame make_frame_in(PictureMemory* memory, AVPixelFormat format, int width, int height);

}  // namespace equistream
