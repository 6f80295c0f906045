#pragma once
/// What decoded pictures are turned into before they are given out.
#include <equistream/depth_agreement.h>
#include <equistream/image.h>
#include <equistream/stream.h>
#include <equistream/yuv.h>

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

// Other people's stereo video, which has both eyes in each picture.

/// Leaves the left eye's half of what `packing` (not none) has both eyes in, the upper one or the left one, and gives
/// the right eye's. Planes are not copied.
DecodedPicture split_eyes(DecodedPicture& picture, StereoPacking packing);

}  // namespace equistream
