#pragma once
/// One coded track: RGB pictures or depth with their frame data in, packets out.
#include "picture_converter.h"

#include <equistream/depth_code.h>
#include <equistream/stream.h>

#include <functional>
#include <optional>
#include <span>

namespace equistream {

/// Pictures by which libx264 and libx265 decode earlier than they show, at most.
inline constexpr std::int64_t longest_reordering = 2;

class TrackEncoder {
public:
    /// `global_header`: the container keeps parameter sets in its header. Throws InputError for unusable settings.
    TrackEncoder(const StreamSettings& settings, const TrackSettings& track, bool global_header);

    const AVCodecContext& codec() const { return *codec_; }
    /// As frame data says it.
    std::optional<float> crf() const { return crf_; }
    /// From the next picture on; libx264 alone can. Of a live stream the next key frame has it in full; else libx264
    /// gives key frames the mean quality of many pictures before.
    void set_crf(double crf);
    /// From the next picture on, which must be a key frame; libx264 alone can.
    void set_size(int width, int height);
    /// RGB to YUV; the result is what encode takes.
    av::Frame convert(ImageView<const std::uint8_t> rgb) const;
    /// The same of PQ R'G'B' where the stream's transfer is that.
    av::Frame convert_pq(ImageView<const float> rgb) const;
    /// Depth to its code's samples; counts into `info` what was too near.
    av::Frame convert(ImageView<const float> depth_m, DepthCodeInfo& info) const;
    /// `payload` travels in the coded picture, unless it is empty. `emit` is called for each packet that is ready.
    void encode(av::Frame picture, std::int64_t pts, std::span<const std::uint8_t> payload,
                const std::function<void(AVPacket&)>& emit);
    void drain(const std::function<void(AVPacket&)>& emit) { send(nullptr, emit); }

private:
    void follow_settings();
    void send(const AVFrame* picture, const std::function<void(AVPacket&)>& emit);
    void require_size(int width, int height, int channels, int wanted_channels) const;
    void require_colour(Transfer transfer) const;

    StreamSettings settings_;
    TrackSettings track_;
    std::unique_ptr<DepthCode> depth_code_;  ///< of depth tracks
    av::Codec codec_;
    std::optional<float> crf_, opened_crf_;  ///< of the next picture, and of the encoder when it was opened
    bool has_strayed_ = false;               ///< its pictures had another one meanwhile
    bool is_outdated_ = false;   ///< the encoder has another size, or keeps parameter sets for the container's header
    std::int64_t pictures_ = 0;  ///< handed to the encoder
    av::Packet packet_ = av::make_packet();
};

/// Throws InputError naming the first setting that cannot be used.
void check_stream_settings(const StreamSettings& settings);

/// The frame rate as a fraction.
AVRational frame_rate_of(const StreamSettings& settings);

}  // namespace equistream
