#include "arrays.h"
#include "parts.h"

#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/object_motion.h>

#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <array>

namespace equistream::python {

namespace {

using Triple = std::array<double, 3>;

Triple triple(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

/// Its pixels in a picture of that size.
nb::object mask_of(const MovingRegion& region, int width, int height) {
    if (width < 1 || height < 1 || width > max_image_side || height > max_image_side)
        throw InputError(expected_found("MovingRegion.mask",
                                        "sides from 1 to " + std::to_string(max_image_side) + " pixels",
                                        size_text(width, height)));
    if (const auto problem = moving_regions_problem({region}, width, height))
        throw InputError("MovingRegion.mask: " + *problem);
    ByteImage mask(width, height, 1);
    for (const PixelRun& run : region.runs)
        std::fill_n(mask.pixel(run.begin, run.row), run.end - run.begin, std::uint8_t{1});
    return to_array(std::move(mask));
}

std::array<std::array<double, 4>, 3> movement_of(const MovingRegion& region, double seconds) {
    const RigidTransform moved = moved_by(region.motion, seconds);
    std::array<std::array<double, 4>, 3> rows;
    for (int i = 0; i < 3; ++i)
        rows[std::size_t(i)] = {moved.rotation[0][i], moved.rotation[1][i], moved.rotation[2][i],
                                moved.translation_m[i]};
    return rows;
}

}  // namespace

void bind_motion(nb::module_& m) {
    nb::class_<MovingRegion>(m, "MovingRegion",
                             "A rigid body that moves by itself, and the pixels of a picture that show it. Vectors are "
                             "along the world's axes, points from the picture's camera. Immutable.")
        .def_prop_ro(
            "velocity_m_s", [](const MovingRegion& r) { return triple(r.motion.twist.velocity_m_s); },
            "v of its twist: a point at p has the velocity v + w x p.")
        .def_prop_ro(
            "angular_rad_s", [](const MovingRegion& r) { return triple(r.motion.twist.angular_rad_s); },
            "w of its twist.")
        .def_prop_ro(
            "velocity_per_second", [](const MovingRegion& r) { return triple(r.motion.twist_per_second.velocity_m_s); },
            "By how much v changes.")
        .def_prop_ro(
            "angular_per_second", [](const MovingRegion& r) { return triple(r.motion.twist_per_second.angular_rad_s); },
            "By how much w changes.")
        .def_ro("near_m", &MovingRegion::near_m, "Distance of the nearest of its surface from the camera.")
        .def_ro("far_m", &MovingRegion::far_m, "Of the farthest.")
        .def_prop_ro("pixels", &MovingRegion::pixels, "How many show it.")
        .def("mask", &mask_of, nb::arg("width"), nb::arg("height"),
             nb::sig("def mask(self, width: int, height: int) -> numpy.typing.NDArray[numpy.uint8]"),
             "1 where a picture of that size, its own, shows it.")
        .def("movement", &movement_of, nb::arg("seconds"),
             "Where its points have moved to after so many seconds: the rows of a 3 x 4 matrix, which takes p, 1.")
        .def("__repr__", [](const MovingRegion& r) {
            return formatted("MovingRegion(%lld pixels, %g to %g m away)", static_cast<long long>(r.pixels()),
                             double(r.near_m), double(r.far_m));
        });
}

}  // namespace equistream::python
