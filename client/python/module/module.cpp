#include "bindings.h"

namespace nb = nanobind;

NB_MODULE(_core, m) {
    m.doc() = "The compiled part of equistream. Use the package `equistream`, which checks what it hands over.";
    m.attr("version") = EQUISTREAM_VERSION;
    // Held by the module for as long as the process lives.
    const nb::exception<equistream::InputError> input_error(m, "InputError", PyExc_ValueError);
    const nb::exception<equistream::WorkError> work_error(m, "WorkError", PyExc_RuntimeError);
    input_error.attr("__doc__") =
        "Bad input, found before work began. The message is one line: where, what was expected, what was found.";
    work_error.attr("__doc__") =
        "Work had begun and could not be finished: a full disk, a stream that was cut, an interrupted wait.";
    equistream::python::bind_cameras(m);
    equistream::python::bind_patches(m);
    equistream::python::bind_motion(m);
    equistream::python::bind_frame_info(m);
    equistream::python::bind_frames(m);
    equistream::python::bind_streams(m);
    equistream::python::bind_reprojection(m);
    equistream::python::bind_colour(m);
}
