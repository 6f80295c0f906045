#pragma once
/// The client, end to end: receive, cast depth, reproject both eyes, fill, write.
#include "report.h"
#include "settings.h"

namespace equistream::play {

/// Plays everything there is and writes OUT/report.json, also when the stream was cut or a later frame failed: then a
/// WorkError says so in the end and everything finished stays. Throws InputError for what is wrong before the first
/// frame.
Report play(const Settings& settings);

}  // namespace equistream::play
