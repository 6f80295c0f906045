#pragma once
/// The reliability map in plain words (client/confidence/reliability.h), one pixel after the other.
#include <client/confidence/reliability.h>

namespace equistream::plain {

/// As equistream's of the same names.
void estimate_reliability(const SourceView& source, const EyeView& eye, EyePicture& picture,
                          const ReliabilityOptions& options = {});
FloatImage reliability_risks(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options = {});
ByteImage reliability_groups(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options = {});

}  // namespace equistream::plain
