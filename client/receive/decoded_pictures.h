#pragma once
/// What decoded pictures are turned into before they are given out.
#include "receive.h"

#include <equistream/depth_agreement.h>
#include <equistream/image.h>
#include <equistream/stream.h>
#include <equistream/yuv.h>

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

// Depth that came at half the columns and rows (depth_code.h), told apart again by the colour, which came whole: joint
// upsampling after Kopf, Cohen, Lischinski, Uyttendaele: Joint bilateral upsampling (2007), but choosing among the
// coded depths, since a mean of two surfaces is a third that nothing is at.
//
// A pixel may take the depth of its own square of four, or of one of the three squares beside the corner that it
// stands in, if that is of another surface (DepthAgreement::connected) and the pixel's luma is nearer to that square's
// mean by at least one step of 8-bit luma, which coding leaves no more of than noise.

/// 8-bit luma of display-referred RGB (see yuv.h).
ByteImage luma_of(ImageView<const std::uint8_t> rgb);
/// The same of an HDR picture's planes, in 8 bits.
ByteImage luma_of(const PqView& planes);

/// `depth_m`: as double_depth gave it; `luma` of the same size. `closes`: the last column lies beside the first. Pure;
/// rows run in parallel.
FloatImage guided_depth(ImageView<const float> depth_m, ImageView<const std::uint8_t> luma,
                        const DepthAgreement& agreement, bool closes);

// Tiles (window.h), each of which came as a picture of its own.

/// One window that holds all tiles that came, at least one; where one between them did not, the base's nearest pixels
/// stand in for it. Pixels lie in `memory`, unless that is null or has no room. Times add up. Throws WorkError unless
/// all are parts of one sphere, seen from one place. Pure.
ReceivedPicture join_tiles(const std::string& where, std::vector<ReceivedPicture> tiles, const ReceivedPicture& base,
                           PictureMemory* memory);

// Video that has both eyes in each picture.

/// Leaves the left eye's half of what `packing` (not none) has both eyes in, the upper one or the left one, and gives
/// the right eye's. The decoder's planes are not copied. Infos stay as they are.
DecodedPicture split_eyes(DecodedPicture& picture, StereoPacking packing);

// All that came of a frame, made into what is given out.

/// By role, each of them or none.
struct DecodedPictures {
    std::array<std::optional<DecodedPicture>, track_role_count> by_role;

    std::optional<DecodedPicture>& picture(TrackRole role) { return by_role[std::size_t(role)]; }
    const std::optional<DecodedPicture>& picture(TrackRole role) const { return by_role[std::size_t(role)]; }
    /// Of their samples.
    std::size_t bytes() const;
};

/// Of one frame.
struct DecodedFrame : DecodedPictures {
    std::map<std::pair<double, double>, DecodedPictures> tiles;  ///< by their first longitude and their last latitude
    std::optional<DecodedPicture> right, right_depth;            ///< of video with both eyes in each picture
    bool posed = true;                                           ///< false for foreign video
};

/// One stream's. `options` are its feed's; `count` is told of each picture that is used. One thread.
class FrameMaker {
public:
    FrameMaker(std::string source, const FeedOptions& options, std::function<void(const DecodedPicture&)> count)
        : source_(std::move(source)), options_(options), count_(std::move(count)) {}

    /// `frame` has its main picture, and every picture its info. Throws WorkError where pictures do not belong
    /// together, InputError where FeedOptions::hdr_display was given for what is not HDR.
    ReceivedFrame make(DecodedFrame frame);

private:
    std::optional<ReceivedPicture> give(DecodedPictures& pictures, TrackRole role, bool posed = true);
    ReceivedPicture with_depth(DecodedPicture&& colour, std::optional<DecodedPicture>& depth);
    std::optional<ReceivedPicture> give_window(DecodedPictures& pictures);
    void give_tiles(DecodedFrame& pictures, ReceivedFrame& frame);
    void give_images(DecodedPictures& pictures, ReceivedPicture& picture, TrackRole role);
    ReceivedPicture received(DecodedPicture&& colour);
    void bring_to_display(ReceivedPicture& picture);
    void require_same_view(const ReceivedPicture& colour, const DecodedPicture& depth) const;

    std::string source_;
    const FeedOptions& options_;
    std::function<void(const DecodedPicture&)> count_;
    std::shared_ptr<const HdrDisplay> display_;  // of HDR pictures; null until the first one
};

}  // namespace equistream
