#pragma once
/// Apple's boxes in MP4 and MOV that say how pictures are to be shown: `vexu` with `eyes`, `proj` and `pack` (Apple,
/// "QuickTime and ISO Base Media File Formats and Spatial and Immersive Media", 2024). libavformat before 7.1 neither
/// writes nor reads them; it knows Google's st3d and sv3d. Files are treated as hostile.
#include <equistream/stream.h>

#include <cstdint>
#include <istream>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace equistream {

/// What a vexu box says that we know how to show.
struct SpatialTags {
    std::optional<LongitudeLatitudeRange> sphere{};  ///< what an equirectangular picture covers; nothing: it is none
    StereoPacking stereo = StereoPacking::none;
    bool right_first = false;            ///< the right eye's half comes first
    std::optional<double> baseline_m{};  ///< between the cameras of both eyes
};

/// The box, whole. Other ranges than the full sphere and its front half have no name there, and are left out; nothing
/// where nothing is left to say.
std::vector<std::uint8_t> vexu_box(const SpatialTags& tags);

/// `header` is an MP4's ftyp and moov, whose first track gets `box` as the last of its sample entry. Returns it
/// unchanged where it has no such entry.
std::vector<std::uint8_t> with_box_in_first_entry(std::span<const std::uint8_t> header,
                                                  std::span<const std::uint8_t> box);

/// By track number (tkhd), of the tracks that have such a box. Looks at 20,000 boxes at most, and holds none in memory.
/// `file` begins with the first box and can be sought in.
std::map<std::uint32_t, SpatialTags> read_spatial_tags(std::istream& file);

/// Whether its movie box says that pictures follow in fragments (`mvex`; ISO 14496-12, 8.8.1). The same of `file`.
bool is_in_fragments(std::istream& file);

}  // namespace equistream
