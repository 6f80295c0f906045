#pragma once
/// Where a viewer would stand who is shown a model without being told where from.
#include "summary.h"

#include <equistream/camera.h>

#include <scenes/library/model.h>

namespace equistream {

/// How high above the ground eyes are.
inline constexpr double eye_height_m = 1.6;

struct Viewpoint {
    Pose pose;
    bool is_inside = false;  ///< among surfaces, as in a room or a street; else in front of the model
    bool is_closed = false;  ///< inside, and no direction leads out
};

/// The model is in metres, within `bounds`. The viewer stands at eye height above some surface with nothing between,
/// where most directions meet surfaces and most of these face the viewer. Of such places one is chosen at the height
/// that most have, farthest from what stands around. The gaze is level, to where surfaces are farthest. Where there is
/// no such place, the viewer stands in front of the model (at +Z, glTF's front), at eye height at most, and sees all of
/// it.
Viewpoint find_viewpoint(const SceneModel& model, const WorldBox& bounds);

}  // namespace equistream
