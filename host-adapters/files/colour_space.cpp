#include <equistream/error.h>
#include <equistream_files/convert.h>

#include <cmath>

namespace equistream::files {

const Chromaticities rec709_chromaticities = {glm::dvec2{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};

namespace {

glm::dvec3 xyz_of(const glm::dvec2& xy) {
    return {xy.x / xy.y, 1, (1 - xy.x - xy.y) / xy.y};
}

/// Columns are the primaries, scaled so that (1, 1, 1) is white.
glm::dmat3 rgb_to_xyz(const Chromaticities& c) {
    const glm::dmat3 primaries(xyz_of(c[0]), xyz_of(c[1]), xyz_of(c[2]));
    const glm::dvec3 scale = glm::inverse(primaries) * xyz_of(c[3]);
    return {primaries[0] * scale.x, primaries[1] * scale.y, primaries[2] * scale.z};
}

/// Lam's cone response matrix, as the ICC uses it.
glm::dmat3 bradford(const glm::dvec2& from_white, const glm::dvec2& to_white) {
    const glm::dmat3 cones =
        glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296));
    const glm::dvec3 gain = (cones * xyz_of(to_white)) / (cones * xyz_of(from_white));
    return glm::inverse(cones) * glm::dmat3({gain.x, 0, 0}, {0, gain.y, 0}, {0, 0, gain.z}) * cones;
}

}  // namespace

glm::dmat3 to_rec709(const Chromaticities& from) {
    bool same = true;
    for (std::size_t i = 0; i < from.size(); ++i) {
        if (!(from[i].y > 1e-6) && std::abs(from[i].y) < 1e-6)
            throw InputError(expected_found("chromaticities", "primaries with y above 0", std::to_string(from[i].y)));
        same = same && glm::length(from[i] - rec709_chromaticities[i]) < 1e-4;
    }
    if (same)
        return glm::dmat3(1);
    return glm::inverse(rgb_to_xyz(rec709_chromaticities)) * bradford(from[3], rec709_chromaticities[3]) *
           rgb_to_xyz(from);
}

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
