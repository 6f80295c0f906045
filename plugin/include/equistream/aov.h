#pragma once
/// The AOV catalogue: every plane a frame can carry, its channels, unit and meaning, in one table.
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

enum class SampleType { half, real, id };  ///< as stored in EXR: 16-bit half, 32-bit float, 32-bit unsigned

struct AovInfo {
    std::string_view name;                       ///< the plane's name in a Frame
    std::string_view group;                      ///< what --aovs calls it; several planes may share a group
    std::span<const std::string_view> channels;  ///< EXR channel names, in the plane's sample order
    SampleType type;
    bool data_part;  ///< in EXR part "data" rather than "rgba"
    std::string_view unit;
    std::string_view meaning;
};

/// All planes, colour first. Geometry planes come from one unfiltered sample along the pixel-centre ray.
///   colour    R G B A     half   scene-referred linear Rec.709 radiance; A = fraction of samples that hit a surface
///   albedo    albedo.RGB  half   diffuse albedo (specular colour of a metal), 0 where nothing is hit
///   depth     depth.Z     real   metres from the camera's centre to the nearest visible surface; +inf for a miss
///   backward  .u .v       real   pixels from here to where the point was in the previous frame
///   forward   .u .v       real   pixels from here to where the point will be in the next frame
///   normal    .X .Y .Z    real   world space, unit, facing the camera; 0 for a miss
///   object_id, material_id, instance_id   id   0 for a miss; numbering starts at 1
std::span<const AovInfo> aov_catalogue();

/// The entry with this plane name, if there is one.
std::optional<AovInfo> find_aov(std::string_view name);

/// Plane names of a comma-separated list of groups ("depth,motion,normal,albedo,ids", "all" or "none"); colour
/// is always first. Throws InputError naming the unknown word and the accepted ones.
std::vector<std::string> parse_aov_groups(std::string_view list);

}  // namespace equistream
