#pragma once
/// Mitsuba's images wrap alike along both axes. One that is to wrap otherwise along v than along u is written as a
/// column of the tiles that some mesh's texture coordinates lie in, each as the wrap along v makes it.
#include <scenes/library/model.h>

#include <functional>
#include <optional>

namespace equistream::mitsuba_xml {

struct Tiles {
    int first = 0, count = 1;  ///< of v: tile t is [t, t + 1)
};

/// The tiles along v that meshes with such a material cover, with one more at either end for filters; nothing if they
/// are too many for an image of that height, or a coordinate is not finite.
std::optional<Tiles> tiles_along_v(const SceneModel& model, int height,
                                   const std::function<bool(const Material&)>& uses);

/// For each row of that column the image's row.
std::vector<int> rows_of(const Tiles& tiles, int height, Wrap wrap_v);

}  // namespace equistream::mitsuba_xml
