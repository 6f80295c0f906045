#pragma once
/// Samples of depth codes in libav's frames.
#include "libav.h"

#include <equistream/planes.h>

#include <optional>

namespace equistream {

AVPixelFormat pixel_format_of(const PlaneFormat& format);

/// An owning frame of that format.
av::Frame make_planes(const PlaneFormat& format, int width, int height);

/// The frame's samples; it must have that format.
PlanesView planes_of(AVFrame& frame, const PlaneFormat& format);

/// The same of a decoded frame, which may have more planes than asked for (H.264 decodes gray with grey chroma);
/// nothing where it does not hold such samples.
std::optional<ConstPlanesView> decoded_planes(const AVFrame& frame, const PlaneFormat& format);

}  // namespace equistream
