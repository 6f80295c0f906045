#include "bindings.h"

#include <client/warp/engine.h>
#include <equistream/camera_limits.h>
#include <equistream/text.h>

#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include <cmath>

namespace equistream::python {

namespace {

using Pair = std::pair<double, double>;
using Points = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;  ///< one point a row

void require(const char* what, const std::optional<Mismatch>& mismatch) {
    if (mismatch)
        throw InputError(expected_found(what, mismatch->expected, mismatch->found));
}

Pose make_pose(const std::array<double, 3>& p, const std::array<double, 4>& q) {
    const glm::dvec3 position_m(p[0], p[1], p[2]);
    const glm::dquat orientation(q[0], q[1], q[2], q[3]);
    require("Pose: position_m", position_mismatch(position_m));
    require("Pose: orientation", orientation_mismatch(orientation));
    return {position_m, orientation / glm::length(orientation)};
}

Pose pose_from_rotation(const std::array<double, 3>& position, const std::array<std::array<double, 3>, 3>& rows) {
    glm::dmat3 rotation;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            rotation[column][row] = rows[std::size_t(row)][std::size_t(column)];
    const glm::dmat3 unity = glm::transpose(rotation) * rotation - glm::dmat3(1);
    for (int i = 0; i < 9; ++i)
        if (!(std::abs(unity[i / 3][i % 3]) < 1e-4))
            throw InputError(
                expected_found("Pose.from_matrix", "a rotation and a translation", "a matrix that scales or shears"));
    if (!(glm::determinant(rotation) > 0))
        throw InputError(expected_found("Pose.from_matrix", "a rotation and a translation", "a matrix that mirrors"));
    const glm::dquat q = glm::normalize(glm::quat_cast(rotation));
    return make_pose(position, {q.w, q.x, q.y, q.z});
}

std::array<std::array<double, 3>, 3> rotation_of(const Pose& pose) {
    const glm::dmat3 m = glm::mat3_cast(pose.orientation);
    std::array<std::array<double, 3>, 3> rows{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            rows[std::size_t(row)][std::size_t(column)] = m[column][row];
    return rows;
}

void require_size(const char* who, int width, int height) {
    if (width < 1 || height < 1 || width > max_image_side || height > max_image_side ||
        std::int64_t{width} * height > max_image_pixels)
        throw InputError(expected_found(who,
                                        "sides from 1 to " + std::to_string(max_image_side) + ", at most " +
                                            std::to_string(max_image_pixels) + " pixels",
                                        size_text(width, height)));
}

EquirectCamera make_equirect(int width, int height, Pair longitudes, Pair latitudes) {
    require_size("EquirectCamera", width, height);
    require("EquirectCamera: longitudes", longitudes_mismatch(longitudes.first, longitudes.second));
    require("EquirectCamera: latitudes", latitudes_mismatch(latitudes.first, latitudes.second));
    return {width, height, {longitudes.first, longitudes.second, latitudes.first, latitudes.second}};
}

PerspectiveCamera make_perspective(int width, int height, double fov_x_rad) {
    require_size("PerspectiveCamera", width, height);
    require("PerspectiveCamera: fov_x_rad", fov_mismatch(fov_x_rad));
    return {width, height, fov_x_rad};
}

/// One row out for each row in.
template <int in, int out, typename Map>
nb::object map_rows(const Points& points, const Map& map) {
    if (points.shape(1) != in)
        throw InputError(
            expected_found("points", std::to_string(in) + " numbers each", std::to_string(points.shape(1))));
    const std::size_t count = points.shape(0);
    auto owned = std::make_unique<double[]>(count * out);
    {
        const nb::gil_scoped_release release;
        for (std::size_t i = 0; i < count; ++i)
            map(points.data() + i * in, owned.get() + i * out);
    }
    double* const data = owned.get();
    const nb::capsule owner(owned.release(), [](void* p) noexcept { delete[] static_cast<double*>(p); });
    const std::size_t shape[] = {count, out};
    return nb::cast(nb::ndarray<nb::numpy, double>(data, 2, shape, owner));
}

template <typename Kind>
nb::object directions_of(const Kind& camera, const Points& pixels) {
    return map_rows<2, 3>(pixels, [&](const double* in, double* out) {
        const glm::dvec3 d = camera.direction(in[0], in[1]);
        out[0] = d.x, out[1] = d.y, out[2] = d.z;
    });
}

template <typename Kind>
nb::object pixels_of(const Kind& camera, const Points& directions) {
    return map_rows<3, 2>(directions, [&](const double* in, double* out) {
        const glm::dvec2 p = camera.pixel({in[0], in[1], in[2]});
        out[0] = p.x, out[1] = p.y;
    });
}

template <typename Kind, typename Class>
void bind_common(Class& camera) {
    camera.def_ro("width", &Kind::width, "Columns.")
        .def_ro("height", &Kind::height, "Rows.")
        .def("pixel_angle_rad", &Kind::pixel_angle_rad, "Angle between neighbouring pixels at the image's middle.")
        .def("_directions", &directions_of<Kind>, nb::arg("pixels"))
        .def("_pixels", &pixels_of<Kind>, nb::arg("directions"))
        .def(
            "__eq__",
            [](const Kind& a, nb::handle b) {
                return nb::isinstance<Kind>(b) && same_camera(Camera(a), Camera(nb::cast<Kind>(b)));
            },
            nb::arg("other").none())
        .def("__hash__", [](const Kind& c) { return std::hash<std::string>{}(size_text(c.width, c.height)); });
}

void bind_pose(nb::module_& m) {
    nb::class_<Pose>(m, "Pose",
                     "Where a camera (or a head) is and how it is turned: world from camera. The world is right-handed "
                     "with +Y up, in metres; a camera looks along its own -Z, +X right, +Y up. Immutable.")
        .def(
            "__init__",
            [](Pose* self, const std::array<double, 3>& p, const std::array<double, 4>& q) {
                new (self) Pose(make_pose(p, q));
            },
            nb::arg("position_m") = std::array<double, 3>{0, 0, 0},
            nb::arg("orientation") = std::array<double, 4>{1, 0, 0, 0})
        .def_prop_ro(
            "position_m",
            [](const Pose& p) {
                return numbers({p.position_m.x, p.position_m.y, p.position_m.z});
            },
            nb::sig("def position_m(self) -> numpy.typing.NDArray[numpy.float64]"), "x, y, z in metres.")
        .def_prop_ro(
            "orientation",
            [](const Pose& p) {
                return numbers({p.orientation.w, p.orientation.x, p.orientation.y, p.orientation.z});
            },
            nb::sig("def orientation(self) -> numpy.typing.NDArray[numpy.float64]"), "Unit quaternion: w, x, y, z.")
        .def_static("_from_rotation", &pose_from_rotation, nb::arg("position_m"), nb::arg("rows"))
        .def("_rotation", &rotation_of)
        .def(
            "__eq__",
            [](const Pose& a, nb::handle b) { return nb::isinstance<Pose>(b) && same_pose(a, nb::cast<Pose>(b)); },
            nb::arg("other").none())
        .def("__hash__", [](const Pose&) { return 1; })  // poses that are nearly the same are equal
        .def("__repr__", [](const Pose& p) {
            const glm::dvec3& at = p.position_m;
            const glm::dquat& q = p.orientation;
            return formatted("Pose(position_m=(%g, %g, %g), orientation=(%g, %g, %g, %g))", at.x, at.y, at.z, q.w, q.x,
                             q.y, q.z);
        });
}

}  // namespace

void bind_cameras(nb::module_& m) {
    bind_pose(m);
    nb::class_<EquirectCamera> equirect(
        m, "EquirectCamera",
        "An equirect image: `width` x `height` pixels over ranges of longitude and latitude in radians, the full "
        "sphere "
        "unless given. Longitude 0 is ahead (-Z) and grows to the right; the top row is up. Immutable.");
    equirect
        .def(
            "__init__",
            [](EquirectCamera* self, int width, int height, Pair longitudes, Pair latitudes) {
                new (self) EquirectCamera(make_equirect(width, height, longitudes, latitudes));
            },
            nb::arg("width"), nb::arg("height"), nb::arg("longitudes") = Pair{-pi, pi},
            nb::arg("latitudes") = Pair{-pi / 2, pi / 2})
        .def_prop_ro(
            "longitudes",
            [](const EquirectCamera& c) {
                return Pair{c.range.longitude_min, c.range.longitude_max};
            },
            "Radians, west and east.")
        .def_prop_ro(
            "latitudes",
            [](const EquirectCamera& c) {
                return Pair{c.range.latitude_min, c.range.latitude_max};
            },
            "Radians, south and north.")
        .def_prop_ro(
            "is_full_sphere", [](const EquirectCamera& c) { return c.range.is_full_sphere(); },
            "Whether every direction has a pixel.")
        .def("__repr__", [](const EquirectCamera& c) {
            std::string text = formatted("EquirectCamera(%d, %d", c.width, c.height);
            if (!c.range.is_full_sphere())
                text += formatted(", longitudes=(%g, %g), latitudes=(%g, %g)", c.range.longitude_min,
                                  c.range.longitude_max, c.range.latitude_min, c.range.latitude_max);
            return text + ")";
        });
    bind_common<EquirectCamera>(equirect);
    nb::class_<PerspectiveCamera> perspective(m, "PerspectiveCamera",
                                              "A perspective view with square pixels and its axis through the middle; "
                                              "the field of view is horizontal. Immutable.");
    perspective
        .def(
            "__init__",
            [](PerspectiveCamera* self, int width, int height, double fov) {
                new (self) PerspectiveCamera(make_perspective(width, height, fov));
            },
            nb::arg("width"), nb::arg("height"), nb::arg("fov_x_rad") = pi / 2)
        .def_ro("fov_x_rad", &PerspectiveCamera::fov_x_rad, "Horizontal field of view.")
        .def("focal_px", &PerspectiveCamera::focal_px, "Focal length in pixels.")
        .def("__repr__", [](const PerspectiveCamera& c) {
            return formatted("PerspectiveCamera(%d, %d, fov_x_rad=%g)", c.width, c.height, c.fov_x_rad);
        });
    bind_common<PerspectiveCamera>(perspective);
    m.def("same_position", &same_position, nb::arg("a"), nb::arg("b"), "Same place to within a nanometre.");
}

}  // namespace equistream::python
