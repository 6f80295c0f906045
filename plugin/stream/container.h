#pragma once
/// Which container a target's name asks for, and how it is written so that a cut file still plays.
#include "libav.h"

#include <equistream/stream.h>

namespace equistream {

struct Container {
    const char* muxer = nullptr;
    bool one_track = false;               ///< raw H.264 or H.265
    bool names_tracks = false;            ///< metadata of a track survive
    bool tags_spheres = false;            ///< what ordinary 360 players look for survives
    std::optional<Codec> only_for_codec;  ///< raw streams say their codec in their extension
};

/// Throws InputError listing the extensions that are known.
Container choose_container(const std::string& target);

/// The muxer's options: written front to back, playable up to any cut.
void set_muxer_options(const Container& container, av::Options& options);

}  // namespace equistream
