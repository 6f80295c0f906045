#pragma once
/// swscale as every conversion here has it: of one size, bicubic, accurate, the same on every processor.
#include "libav.h"

namespace equistream {

/// Set up but for sws_init_context().
av::Scaler make_scaler(int width, int height, int from_pixel_format, int to_pixel_format);
/// One of swscale's own names.
void set_scaling(SwsContext& scaler, const char* option, int value);

}  // namespace equistream
