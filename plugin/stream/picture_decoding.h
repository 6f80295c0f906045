#pragma once
/// Decoders that write their pictures into memory that was handed to them (libavcodec's direct rendering), and what
/// their callbacks know.
#include "libav.h"

#include <equistream/yuv.h>

#include <string_view>

namespace equistream {

/// What AVCodecContext::opaque points at; outlives the context.
struct DecoderCallbacks {
    AVPixelFormat hardware_format = AV_PIX_FMT_NONE;  ///< of pictures in a device's memory; none: there is no device
    std::shared_ptr<PictureMemory> memory;            ///< null: libavcodec's own
};

/// Before the decoder is opened, whose `opaque` says where to. Pictures of another kind than equistream/yuv.h and yuv.h
/// describe, those of decoders that cannot, and those that there is no memory for lie where they always did.
void render_into_memory(AVCodecContext& codec);

/// An owning frame of that format and size in memory that was handed over, else in ordinary memory; null: there is
/// none.
av::Frame make_frame_in(PictureMemory* memory, AVPixelFormat format, int width, int height);

// Decoding by whatever hardware libavcodec finds (VAAPI, CUDA, ...), pictures fetched into ordinary memory.
// Where there is none, or it does not take this stream, nothing is said and the decoder works by itself.

class HardwareDecoding {
public:
    HardwareDecoding() = default;
    ~HardwareDecoding() { av_buffer_unref(&device_); }
    HardwareDecoding(const HardwareDecoding&) = delete;
    HardwareDecoding& operator=(const HardwareDecoding&) = delete;

    /// Opens a device for this codec, if there is one. For 4:2:0 of 8 bits alone: what else there is, hardware hands
    /// over in layouts of its own.
    void look_for(const AVCodecParameters& parameters);
    /// Before the decoder is opened, whose `opaque` these are; lives as long as it does.
    void offer_to(AVCodecContext& codec, DecoderCallbacks& callbacks) const;
    /// What decoded this picture: "software" or the device's name, of static lifetime. Before fetch().
    std::string_view name_of(const AVFrame& frame) const;
    /// A picture in the device's memory becomes one of planes Y, Cb and Cr here, in `memory` where that has room (null:
    /// ordinary memory); others stay. False where the device does not give it.
    bool fetch(av::Frame& frame, PictureMemory* memory) const;

private:
    AVBufferRef* device_ = nullptr;
    AVHWDeviceType type_ = AV_HWDEVICE_TYPE_NONE;
    AVPixelFormat format_ = AV_PIX_FMT_NONE;  ///< of pictures in its memory
};

/// Chroma that alternates (NV12) in planes of its own, in `memory` where that has room; what is not NV12 stays. Null:
/// there is no memory.
av::Frame with_own_chroma_planes(av::Frame frame, PictureMemory* memory = nullptr);

}  // namespace equistream
