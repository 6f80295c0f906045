#include "arrays.h"
#include "parts.h"
#include "waiting.h"

#include <equistream_client/engine.h>
#include <equistream_client/fill.h>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include <optional>
#include <vector>

namespace equistream::python {

namespace {

/// Arrays and what they show; holds the arrays, so that their samples stay.
struct Source {
    ArrayIn<std::uint8_t> rgb;
    Camera camera;
    Pose pose;
    std::optional<ArrayIn<float>> depth_m;
    double box_radius_m = 0;

    SourceView view() const {
        return {.rgb = view_of(rgb),
                .camera = camera,
                .pose = pose,
                .depth_m = depth_m ? view_of(*depth_m) : ImageView<const float>{},
                .box_radius_m = box_radius_m};
    }
};

class Reprojector {
public:
    Reprojector(const std::string& method, const std::string& fill, double error_budget_px, bool reference)
        : engine_(make_engine(method, {.error_budget_px = error_budget_px, .reference = reference})),
          ladder_(make_fill_ladder(fill)) {}

    DepthNeeds needs_depth(const Pose& source, const Pose& eye) const { return engine_->needs_depth(source, eye); }
    bool fill_wants_depth() const {
        return std::any_of(ladder_.begin(), ladder_.end(), [](const auto& rung) { return rung->wants_depth(); });
    }

    /// The eye's picture: rgba, origin, gaps before any fill, how many pixels each rung filled, and the depth that the
    /// engine found, or None.
    nb::tuple reproject(const Source& source, const std::optional<Source>& small, const PerspectiveCamera& camera,
                        const Pose& pose, const std::optional<ArrayIn<float>>& depth_m) {
        EyePicture picture;
        ByteImage origin_before_fill;
        FilledCounts filled;
        waiting_.run([&] {
            const EyeView eye{camera, pose, depth_m ? view_of(*depth_m) : ImageView<const float>{}};
            engine_->set_source(source.view());
            engine_->reproject(eye, picture);
            origin_before_fill = picture.origin;
            const SourceView main = source.view();
            const std::optional<SourceView> second = small ? std::optional(small->view()) : std::nullopt;
            for (const auto& rung : ladder_)
                rung->set_frame({.main = &main, .small = second ? &*second : nullptr});
            filled = fill_gaps(ladder_, eye, picture);
        });
        nb::dict counts;
        for (const auto& [name, count] : filled)
            counts[name.c_str()] = count;
        const nb::object found = picture.depth_m.empty() ? nb::none() : nb::cast(to_array(std::move(picture.depth_m)));
        return nb::make_tuple(to_array(std::move(picture.rgba)), to_array(std::move(picture.origin)),
                              to_array(std::move(origin_before_fill)), counts, found);
    }

private:
    Waiting waiting_{"Reprojector"};
    std::unique_ptr<Engine> engine_;
    FillLadder ladder_;
};

}  // namespace

void bind_reprojection(nb::module_& m) {
    nb::list methods;
    for (const std::string_view name : engine_names())
        methods.append(std::string(name));
    m.attr("METHODS") = nb::tuple(methods);
    nb::class_<Source>(m, "Source")
        .def(
            "__init__",
            [](Source* self, ArrayIn<std::uint8_t> rgb, const Camera& camera, const Pose& pose,
               std::optional<ArrayIn<float>> depth_m, double box_radius_m) {
                new (self) Source{std::move(rgb), camera, pose, std::move(depth_m), box_radius_m};
            },
            nb::arg("rgb"), nb::arg("camera"), nb::arg("pose"), nb::arg("depth_m").none(), nb::arg("box_radius_m"));
    nb::class_<DepthNeeds>(m, "DepthNeeds", "Whose depth a reprojection cannot do without.")
        .def_ro("source", &DepthNeeds::source)
        .def_ro("eye", &DepthNeeds::eye)
        .def("__bool__", &DepthNeeds::any, "Whether anybody's.")
        .def("__repr__", [](const DepthNeeds& needs) {
            const auto word = [](bool value) { return std::string(value ? "True" : "False"); };
            return "DepthNeeds(source=" + word(needs.source) + ", eye=" + word(needs.eye) + ")";
        });
    nb::class_<Reprojector>(m, "Reprojector")
        .def(nb::init<const std::string&, const std::string&, double, bool>(), nb::arg("method"), nb::arg("fill"),
             nb::arg("error_budget_px"), nb::arg("reference"))
        .def("needs_depth", &Reprojector::needs_depth, nb::arg("source"), nb::arg("eye"))
        .def("fill_wants_depth", &Reprojector::fill_wants_depth)
        .def("reproject", &Reprojector::reproject, nb::arg("source"), nb::arg("small").none(), nb::arg("camera"),
             nb::arg("pose"), nb::arg("depth_m").none());
}

}  // namespace equistream::python
