#pragma once
/// Structs that hosts fill, in every size they have had: a host built with an older header hands over a shorter one.
#include "whole_struct.h"

#include <equistream/equistream.h>

namespace equistream {

/// Ascending, today's last. When a field is appended to a struct, that field's offset goes before the last.
inline constexpr std::size_t sequence_settings_sizes[] = {
    offsetof(es_sequence_settings, geometry_fingerprint), offsetof(es_sequence_settings, layer),
    offsetof(es_sequence_settings, patch_side), sizeof(es_sequence_settings)};
inline constexpr std::size_t frame_settings_sizes[] = {offsetof(es_frame_settings, patches), sizeof(es_frame_settings)};
inline constexpr std::size_t plane_sizes[] = {sizeof(es_plane)};

static_assert(sizeof(void*) != 8 ||
                  (sequence_settings_sizes[0] == 176 && frame_settings_sizes[0] == 192 && plane_sizes[0] == 40),
              "the sizes that the first hosts were built with");

}  // namespace equistream
