#include "bindings.h"

#include <equistream/colour.h>

#include <nanobind/stl/string.h>

namespace equistream::python {

void bind_colour(nb::module_& m) {
    nb::class_<DisplayTransform>(m, "DisplayTransform")
        .def(nb::init<const std::string&>(), nb::arg("view") = default_view)
        .def(
            "to_display",
            [](const DisplayTransform& self, const ArrayIn<float>& linear, double exposure) {
                FloatImage display;
                {
                    const nb::gil_scoped_release release;
                    display = self.to_display(view_of(linear), exposure);
                }
                return to_array(std::move(display));
            },
            nb::arg("linear"), nb::arg("exposure"))
        .def(
            "to_linear",
            [](const DisplayTransform& self, const ArrayIn<float>& display, double exposure) {
                FloatImage linear;
                {
                    const nb::gil_scoped_release release;
                    linear = self.to_linear(view_of(display), exposure);
                }
                return to_array(std::move(linear));
            },
            nb::arg("display"), nb::arg("exposure"));
    m.def(
        "quantise_8bit", [](const ArrayIn<float>& display) { return to_array(quantise_8bit(view_of(display))); },
        nb::arg("display"));
}

}  // namespace equistream::python
