#pragma once
/// The generators themselves; generators() is their table.
#include "generate.h"

namespace equistream::generate {

GeneratedScene make_pavilion(const GeneratorValues&);
GeneratedScene make_orientation(const GeneratorValues&);
GeneratedScene make_sphere(const GeneratorValues& values);
GeneratedScene make_furnace(const GeneratorValues& values);
GeneratedScene make_motion(const GeneratorValues& values);
GeneratedScene make_materials(const GeneratorValues&);
GeneratedScene make_empty(const GeneratorValues&);

inline constexpr GeneratorOption motion_options[] = {
    {"seconds", "1", "how long things move, there in one second and back in the next"},
};
inline constexpr GeneratorOption sphere_options[] = {
    {"radius", "3", "metres"},
    {"n", "256", "depths seen from the centre lie in [radius cos(pi/n), radius]"},
    {"offset", "0", "the camera's distance from the centre along +X, in radii"},
};

inline constexpr std::string_view furnace_kinds[] = {"open", "closed"};
inline constexpr GeneratorOption furnace_options[] = {
    {"kind", "open", "open: balls of albedo 1 under a sky of 1; closed: walls and balls that emit 1/2 and reflect 1/2"},
};

}  // namespace equistream::generate
