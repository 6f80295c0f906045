#include "convert.h"

#include <equistream/error.h>

namespace equistream::files {

Chromaticities named_chromaticities(const std::string& name) {
    constexpr glm::dvec2 aces_white{0.32168, 0.33767};
    if (name == "rec709")
        return rec709_chromaticities;
    if (name == "rec2020")
        return {glm::dvec2{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}};
    if (name == "acescg")
        return {glm::dvec2{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, aces_white};
    if (name == "aces2065-1")
        return {glm::dvec2{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, aces_white};
    throw InputError(expected_found("--colour-space", "auto, rec709, rec2020, acescg or aces2065-1", "'" + name + "'"));
}

}  // namespace equistream::files
