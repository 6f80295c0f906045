#pragma once
/// The order in which a source's samples may be drawn over one another without comparing depths (McMillan, "A
/// list-priority rendering algorithm for redisplaying projected surfaces", 1995; "An image-based approach to
/// three-dimensional computer graphics", 1997).
///
/// Points that meet in one pixel of the eye lie on one half circle from the antipode of the eye's direction (the
/// epipole) to the epipole, the nearer the closer to the epipole: drawing along every such half circle towards the
/// epipole draws the nearest last. On a sphere's picture the longitude along it runs one way, from the epipole's
/// opposite meridian to its own; so columns come in order of their longitude's distance from the epipole's, farthest
/// first, those on either side in any order. Within a column the half circles run towards the latitude p* with tan p* =
/// tan(p_epipole) / cos(dl) in the epipole's hemisphere of longitudes, and away from it in the other; rows follow. In a
/// perspective picture half circles are straight and run to the epipole's image where the eye is in front of the
/// source, else away from where the antipode's image is: columns and rows in order of their distance from it.
#include "eye_rays.h"

#include <equistream/camera.h>

#include <vector>

namespace equistream {

class SplatOrder {
public:
    /// `eye`: in the source's frame, not zero.
    SplatOrder(const Camera& source, const glm::dvec3& eye);

    /// Columns by distance: larger is drawn earlier.
    double earliness(int column) const { return earliness_[std::size_t(column)]; }
    /// Rows above and below this one are drawn towards it (or away from it), each side for itself.
    double turning_row(int column) const { return turning_row_[std::size_t(column)]; }
    bool towards_turning_row(int column) const { return towards_[std::size_t(column)] != 0; }

private:
    std::vector<double> earliness_, turning_row_;
    std::vector<char> towards_;
};

}  // namespace equistream
