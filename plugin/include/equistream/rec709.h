#pragma once
/// Linear Rec.709, the colour space of all radiance in equistream: luminance, conversion from other primaries, and the
/// sRGB transfer curve. Pure functions.
#include <equistream/error.h>

#include <plugin/formulas/scalars.h>

#include <glm/glm.hpp>

#include <array>
#include <cmath>

namespace equistream {

/// CIE 1931 x and y of red, green, blue and white.
using Chromaticities = std::array<glm::dvec2, 4>;

inline constexpr Chromaticities rec709_chromaticities = {
    glm::dvec2{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};

/// Luminance Y of linear Rec.709, for a vec3 or dvec3 (ITU-R BT.709 coefficients).
template <typename Colour>
auto luminance(const Colour& c) {
    using T = typename Colour::value_type;
    return T(0.2126) * c.x + T(0.7152) * c.y + T(0.0722) * c.z;
}

namespace primaries {

/// CIE XYZ with Y = 1.
inline glm::dvec3 xyz_of(const glm::dvec2& xy) {
    return {xy.x / xy.y, 1, (1 - xy.x - xy.y) / xy.y};
}

/// The matrix from linear RGB to CIE XYZ. Columns are the primaries, scaled so that (1, 1, 1) is white with Y = 1.
inline glm::dmat3 rgb_to_xyz(const Chromaticities& c) {
    const glm::dmat3 columns(xyz_of(c[0]), xyz_of(c[1]), xyz_of(c[2]));
    const glm::dvec3 scale = glm::inverse(columns) * xyz_of(c[3]);
    return {columns[0] * scale.x, columns[1] * scale.y, columns[2] * scale.z};
}

/// Chromatic adaptation of XYZ from one white to another, by the Bradford cone matrix (Lam 1985), as in ICC profiles.
inline glm::dmat3 bradford(const glm::dvec2& from_white, const glm::dvec2& to_white) {
    const glm::dmat3 cones =
        glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296));
    const glm::dvec3 gain = (cones * xyz_of(to_white)) / (cones * xyz_of(from_white));
    return glm::inverse(cones) * glm::dmat3({gain.x, 0, 0}, {0, gain.y, 0}, {0, 0, gain.z}) * cones;
}

}  // namespace primaries

/// The matrix from linear RGB with these primaries to linear Rec.709, with Bradford adaptation if the white differs.
/// Exactly the unit matrix for Rec.709's own primaries (each within 1e-4). Throws InputError naming `where` for
/// primaries that span no triangle around white.
inline glm::dmat3 to_rec709(const Chromaticities& from, const std::string& where) {
    bool same = true;
    for (std::size_t i = 0; i < from.size(); ++i)
        same = same && glm::length(from[i] - rec709_chromaticities[i]) < 1e-4;
    if (same)
        return glm::dmat3(1);
    const glm::dmat3 matrix = glm::inverse(primaries::rgb_to_xyz(rec709_chromaticities)) *
                              primaries::bradford(from[3], rec709_chromaticities[3]) * primaries::rgb_to_xyz(from);
    for (int i = 0; i < 9; ++i)
        if (!(std::abs(matrix[i / 3][i % 3]) < 1e6))
            throw InputError(expected_found(where, "chromaticities that span a triangle around white", "others"));
    return matrix;
}

// The sRGB transfer curve (IEC 61966-2-1) on values from 0 to 1, per channel. Pure functions.

using formulas::linear_to_srgb;
using formulas::srgb_to_linear;

}  // namespace equistream
