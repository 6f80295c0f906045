#pragma once
/// What tracks of distances cost, and how depth is best coded for that, tried on a few frames.
#include "depth_tracks.h"

namespace equistream {

/// A track as it is, on the same few frames.
DepthTrial try_track(const DepthTrack& track, const Beside& beside);

/// Gives main's depth the code and the size, of those that the request leaves open, and all tracks the CRF, that leave
/// most of main's pixels within the bound while the bytes of all tracks together stay within the share asked for;
/// of those that leave practically all there, the cheapest. Does nothing where main has no depth, where the CRF was
/// given or where it does not matter.
void choose_depth(const DepthRequest& request, const Beside& beside, DepthPlan& plan);

}  // namespace equistream
