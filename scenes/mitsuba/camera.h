#pragma once
/// The camera path's pose as a Mitsuba sensor.
#include "convert.h"

#include <pugixml.hpp>

namespace equistream::mitsuba_xml {

/// `farthest_m`: how far rays have to reach.
void add_sensor(pugi::xml_node scene, const SceneDescription& description, const MitsubaSettings& settings,
                double farthest_m);

}  // namespace equistream::mitsuba_xml
