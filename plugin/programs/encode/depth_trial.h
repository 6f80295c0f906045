#pragma once
/// What tracks of distances cost, and which CRF depth takes, tried on a few frames.
#include "depth_tracks.h"

namespace equistream {

/// A track as it is, on the same few frames.
DepthTrial try_track(const DepthTrack& track, const Sources& sources, const StreamSettings& settings);

/// Gives all tracks the one that suits main's depth: the best whose bytes stay within the share asked for; or a worse
/// one that leaves practically all pixels within the bound all the same. Does nothing where the CRF was given or does
/// not matter.
void choose_crf(const DepthRequest& request, const Sources& sources, const StreamSettings& settings, DepthPlan& plan);

}  // namespace equistream
