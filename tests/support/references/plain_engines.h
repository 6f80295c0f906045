#pragma once
/// The engines and the rework of mirrors in plain words: double precision, one pixel after the other, through the
/// public cameras. Tests hold the product's own to them; nothing else links them.
#include <client/confidence/reliability.h>
#include <client/reflections/specular.h>
#include <client/warp/engine.h>

namespace equistream::plain {

/// Of the same name and options as equistream::make_engine's.
std::unique_ptr<Engine> make_engine(std::string_view name, const EngineOptions& options = {});

/// As equistream::rework_specular.
SpecularCounts rework_specular(const SourceView& source, const EyeView& eye, EyePicture& picture,
                               const SpecularOptions& options = {});

// The reliability map in plain words (client/confidence/reliability.h), one pixel after the other.

/// As equistream's of the same names.
void estimate_reliability(const SourceView& source, const EyeView& eye, EyePicture& picture,
                          const ReliabilityOptions& options = {});
FloatImage reliability_risks(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options = {});
ByteImage reliability_groups(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                             const ReliabilityOptions& options = {});

}  // namespace equistream::plain
