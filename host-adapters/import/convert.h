#pragma once
/// A frame of another renderer made one of ours, plane by plane.
#include "channel_map.h"
#include "source_conventions.h"

#include <equistream/frame.h>
#include <equistream/window.h>

#include <glm/glm.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream::files {

/// "rec709", "rec2020", "acescg", "aces2065-1"; throws InputError with the accepted names.
Chromaticities named_chromaticities(const std::string& name);

/// World from camera as ours (+Y up, looking along -Z), of a file's worldToCamera. `taken_for` tells how it was read.
Pose pose_of_attribute(const ForeignExr& file, const SourceConventions& conventions, std::string& taken_for);

/// Horizontal field of view that worldToCamera and worldToNDC give together, whether NDC runs from 0 or from -1;
/// nothing where there are not both, or they are no perspective view through its middle.
std::optional<double> fov_of_attributes(const ForeignExr& file, const SourceConventions& conventions);

/// Turned from a world whose up is +Z into ours.
Pose pose_from_z_up(const Pose& pose);

/// What a frame is converted with.
struct Conversion {
    SourceConventions conventions;
    Camera camera;
    Pose camera_pose;                    ///< as the source's camera looks; convert_frame turns a sphere's by forward_at
    std::optional<Pose> previous, next;  ///< the same of the neighbours, where they are known: misses move by them
    glm::dmat3 colour_to_rec709{1};
    bool pose_is_known = false;  ///< else normals in world space stay as they face
    /// Columns of the sphere that the picture is a part of, which has half as many rows; nothing: it is the whole.
    std::optional<int> sphere_columns{};
};

/// The pose that the frame gets: a sphere whose middle is not where the camera looks is turned instead of resampled.
Pose sphere_pose(const Conversion& conversion, const Pose& camera_pose);

/// Reads the mapped planes and converts them; `info` holds all but camera and camera_pose, which are set here. Throws
/// InputError naming file, plane and pixel. `notes` gets a line for what was put right.
Frame convert_frame(const std::vector<const ForeignExr*>& files, const ChannelMap& map, const Conversion& conversion,
                    const FrameInfo& info, std::vector<std::string>& notes);

/// The window on which all files of a frame have pixels: whole blocks of the sphere that their display window is, and
/// where these are once a `mirrored` sphere was flipped. Nothing where there are none.
std::optional<std::pair<WindowGrid, WindowPlace>> window_of(const std::vector<const ForeignExr*>& files, bool mirrored);
/// A frame of a whole sphere becomes one of its window.
void cut_out(const WindowGrid& grid, WindowPlace place, Frame& frame);

}  // namespace equistream::files
