#pragma once
/// What a renderer means by its numbers: everything that has to be known before they can become ours. Plain values.
#include "foreign_exr.h"

#include <glm/glm.hpp>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::files {

enum class DepthKind {
    radial,    ///< along the ray, as ours
    planar,    ///< along the camera's axis
    position,  ///< three channels: the point itself, in the camera's frame
};

enum class MotionEnds { to_previous, from_previous, to_next, from_next };  ///< where minus where
enum class MotionUnit { pixels, normalised, ndc };  ///< pixels; 0 to 1 or -1 to 1 over the image's width and height

/// One field of motion vectors.
struct MotionConvention {
    MotionEnds ends = MotionEnds::to_previous;
    MotionUnit unit = MotionUnit::pixels;
    bool y_up = false;
};

/// "to-previous,pixels,y-up"; a word that is left out keeps its default. Throws InputError with the accepted words.
MotionConvention parse_motion(std::string_view words, const char* option);
std::string motion_text(const MotionConvention& motion);

enum class NormalSpace {
    world,
    camera,            ///< +X right, +Y up, -Z forward
    camera_z_forward,  ///< +X right, +Y up, +Z forward
};

struct SourceConventions {
    std::string name = "none";  ///< of the preset
    DepthKind depth = DepthKind::radial;
    double depth_scale_m = 1;  ///< metres a unit
    double near_plane_m = 0;   ///< what depth was shortened by, along the camera's axis; a preset's in the scene's unit
    std::optional<double> miss_value;  ///< exactly this means nothing was hit
    double miss_above = 1e9;           ///< this and more too, before scaling
    std::optional<MotionConvention> backward, forward;
    NormalSpace normals = NormalSpace::world;
    bool normals_encoded = false;  ///< (n + 1) / 2
    bool mirrored = false;         ///< equirect: longitude grows to the left
    bool one_row_low = false;      ///< equirect: a row has what belongs into the one above it
    double forward_at = 0.5;       ///< equirect: fraction of the width at which the camera looks
    bool z_up = false;             ///< the world's up is +Z
    bool column_vectors = false;   ///< worldToCamera has its translation in the last column
    bool takes_guides = false;     ///< a denoiser's: averaged planes that look through mirrors
    /// By plane, which of the file's channels; overrides what is found by name. An empty list: leave the plane out.
    std::map<std::string, std::vector<std::string>> channels;
};

/// Everything that decides a pixel, exactly: other conventions give other texts. Which channels are meant is not in it.
std::string identity_of(const SourceConventions& conventions);

std::vector<std::string> preset_names();
/// Throws InputError naming the presets that are known.
SourceConventions preset(const std::string& name);
/// The preset that a file's own words speak for; "none" where they do not.
std::string guess_preset(const ForeignExr& file);

}  // namespace equistream::files
