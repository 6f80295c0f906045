#include "bindings.h"

#include <equistream/colour.h>

#include <nanobind/stl/string.h>

namespace equistream::python {

void bind_colour(nb::module_& m) {
    const auto conversion = [](FloatImage (DisplayTransform::*convert)(ImageView<const float>, double) const) {
        return [convert](const DisplayTransform& self, const ArrayIn<float>& samples, double exposure) {
            FloatImage converted;
            {
                const nb::gil_scoped_release release;
                converted = (self.*convert)(view_of(samples), exposure);
            }
            return to_array(std::move(converted));
        };
    };
    nb::class_<DisplayTransform>(m, "DisplayTransform")
        .def(nb::init<const std::string&>(), nb::arg("view") = default_view)
        .def("to_display", conversion(&DisplayTransform::to_display), nb::arg("linear"), nb::arg("exposure"))
        .def("to_linear", conversion(&DisplayTransform::to_linear), nb::arg("display"), nb::arg("exposure"));
    m.def(
        "quantise_8bit", [](const ArrayIn<float>& display) { return to_array(quantise_8bit(view_of(display))); },
        nb::arg("display"));
}

}  // namespace equistream::python
