#include "bindings.h"

#include <client/pipeline/decisions.h>
#include <client/pipeline/eye_steps.h>

#include <client/confidence/reliability.h>
#include <client/fill/fill.h>
#include <client/reflections/specular.h>
#include <client/stages/stages.h>
#include <client/warp/engine.h>
#include <equistream/frame.h>
#include <equistream/patches.h>

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <vector>

namespace equistream::python {

namespace {

/// Colour as RGB or, where that is None, as a decoder's planes.
struct Colours {
    std::optional<ArrayIn<std::uint8_t>> rgb;
    std::optional<PlanesIn> yuv;

    ImageView<const std::uint8_t> rgb_view() const { return rgb ? view_of(*rgb) : ImageView<const std::uint8_t>{}; }
    YuvView yuv_view() const { return rgb || !yuv ? YuvView{} : view_of(*yuv); }
    bool fits(int width, int height) const {
        const auto sized = [&](const auto& array) {
            return static_cast<int>(array.shape(1)) == width && static_cast<int>(array.shape(0)) == height;
        };
        return rgb ? sized(*rgb) : yuv && sized((*yuv)[0]);
    }
};

/// Arrays and what they show; holds the arrays, so that their samples stay.
struct Source {
    Colours colours;
    Camera camera;
    Pose pose;
    std::optional<ArrayIn<float>> depth_m;
    double box_radius_m = 0;
    std::optional<ArrayIn<float>> specular{}, virtual_depth_m{};

    SourceView view() const {
        const auto plane = [](const std::optional<ArrayIn<float>>& array) {
            return array ? view_of(*array) : ImageView<const float>{};
        };
        return {.rgb = colours.rgb_view(),
                .yuv = colours.yuv_view(),
                .camera = camera,
                .pose = pose,
                .depth_m = plane(depth_m),
                .specular = plane(specular),
                .virtual_depth_m = plane(virtual_depth_m),
                .box_radius_m = box_radius_m};
    }
};

/// An atlas' picture, and what its pixels show.
struct Patches {
    Colours colours;
    ArrayIn<float> depth_m;
    FrameInfo info;
    double box_radius_m = 0;

    PatchesView view() const {
        return {.rgb = colours.rgb_view(),
                .yuv = colours.yuv_view(),
                .depth_m = view_of(depth_m),
                .atlas = &*info.patches,
                .pose = info.camera_pose,
                .box_radius_m = box_radius_m};
    }
};

/// What gaps may be filled from.
struct FillFrom {
    std::optional<Source> base, small, hidden;
    std::optional<Patches> patches;
    std::vector<Source> earlier;
};

/// The same as fill passes take it.
struct FillViews {
    SourceView main;
    std::optional<SourceView> base, small, hidden;
    std::optional<PatchesView> patches;
    std::vector<SourceView> earlier;

    FillViews(const Source& source, const FillFrom& from) : main(source.view()) {
        const auto see = [](const auto& other, auto& view) {
            if (other)
                view = other->view();
        };
        see(from.base, base);
        see(from.small, small);
        see(from.hidden, hidden);
        see(from.patches, patches);
        for (const Source& other : from.earlier)
            earlier.push_back(other.view());
    }
    FillInputs inputs(double error_budget_px, const BaseEngine& base_engine) const {
        const auto address = [](const auto& view) { return view ? &*view : nullptr; };
        return {.main = &main,
                .small = address(small),
                .base = address(base),
                .base_engine = &base_engine,
                .earlier = earlier,
                .hidden = address(hidden),
                .patches = address(patches),
                .error_budget_px = error_budget_px};
    }
};

/// What is wanted besides colours; by how much w of the depth may be off, and how visibly off the colours are.
struct Assess {
    bool reliability = false, risks = false;
    double depth_tolerance_w = 0;
    std::optional<VisibleLoss> visible_loss{};
};

class Reprojector {
public:
    Reprojector(const std::string& method, const std::string& fill, std::optional<double> error_budget_px,
                const std::string& mirrors)
        : steps_(method, options_of(error_budget_px), find_mirror_treatment(mirrors)),
          base_engine_(method, options_of(error_budget_px)), chain_(make_fill_chain(fill)),
          error_budget_px_(error_budget_px.value_or(default_error_budget_px)) {}

    DepthNeeds needs_depth(const Pose& source, const Pose& eye) const {
        return steps_.engine().needs_depth(source, eye);
    }
    bool fill_wants_depth() const {
        return std::any_of(chain_.begin(), chain_.end(),
                           [](const auto& fill_pass) { return fill_pass->wants_depth(); });
    }

    /// The eye's picture by its planes' names; `origin_before_fill` is that of the engine and of mirrors, `mirrors` and
    /// `filled` count pixels. `depth_m` is None unless the engine found it; what `assess` does not ask for is empty.
    nb::dict reproject(const Source& source, const FillFrom& from, const PerspectiveCamera& camera, const Pose& pose,
                       const std::optional<ArrayIn<float>>& depth_m, const Assess& assess) {
        EyePicture picture;
        FloatImage risks(0, 0, risk_count);
        ByteImage risk_groups;
        ByteImage origin_before_fill;
        SpecularCounts specular;
        FilledCounts filled;
        waiting_.run([&] {
            const EyeView eye{camera, pose, depth_m ? view_of(*depth_m) : ImageView<const float>{}};
            const FillViews views(source, from);
            steps_.set_source(views.main);
            specular = steps_.reproject(eye, picture);
            origin_before_fill = picture.origin;
            if (views.base)
                base_engine_.set_base(*views.base);
            for (const auto& fill_pass : chain_)
                fill_pass->set_frame(views.inputs(error_budget_px_, base_engine_));
            filled = fill_gaps(chain_, eye, picture);
            const ReliabilityOptions options =
                confidence_options(assess.depth_tolerance_w, assess.visible_loss, steps_.mirrors());
            if (assess.reliability)
                steps_.judge(eye, picture, options);
            if (assess.risks) {
                risks = reliability_risks(views.main, eye, picture, options);
                risk_groups = reliability_groups(views.main, eye, picture, options);
            }
        });
        nb::dict found;
        found["filled"] = nb::dict();
        for (const auto& [name, count] : filled)
            found["filled"][name.c_str()] = count;
        found["mirrors"] = counts_of(specular);
        found["depth_m"] = picture.depth_m.empty() ? nb::none() : to_array(std::move(picture.depth_m));
        found["rgba"] = to_array(std::move(picture.rgba));
        found["origin"] = to_array(std::move(picture.origin));
        found["origin_before_fill"] = to_array(std::move(origin_before_fill));
        found["reliability"] = to_array(std::move(picture.reliability));
        found["risks"] = to_array(std::move(risks));
        found["risk_groups"] = to_array(std::move(risk_groups));
        return found;
    }

private:
    static EngineOptions options_of(const std::optional<double>& error_budget_px) {
        if (!error_budget_px)
            return {};
        return {.error_budget_px = *error_budget_px, .source_depth_budget_px = *error_budget_px};
    }
    static nb::dict counts_of(const SpecularCounts& counts) {
        nb::dict words;
        words["kept"] = counts.kept;
        words["by_image"] = counts.by_image;
        words["displaced"] = counts.displaced;
        words["gaps"] = counts.gaps;
        return words;
    }

    Waiting waiting_{"Reprojector"};
    EyeSteps steps_;
    BaseEngine base_engine_;
    FillChain chain_;
    double error_budget_px_;
};

}  // namespace

void bind_reprojection(nb::module_& m) {
    const auto tuple_of = [](const auto& names) {
        nb::list list;
        for (const std::string_view name : names)
            list.append(std::string(name));
        return nb::tuple(list);
    };
    m.attr("METHODS") = tuple_of(names_of(engine_stages()));
    m.attr("FILL_PASSES") = tuple_of(names_of(fill_stages()));
    std::vector<std::string_view> of_small;
    for (const FillStage& stage : fill_stages())
        if (stage.reads[std::size_t(TrackRole::small)])
            of_small.push_back(stage.name);
    m.attr("SMALL_PASSES") = tuple_of(of_small);
    m.def(
        "method_of_today", [](const std::string& name) { return std::string(find_engine(name, "method").name); },
        nb::arg("name"));
    m.attr("MIRRORS") = tuple_of(mirror_treatment_names());
    m.attr("DEFAULT_FILL") = default_fill;
    m.attr("RISKS") = tuple_of(risk_names);
    m.attr("RISK_GROUPS") = tuple_of(risk_group_names);
    m.attr("RELIABILITY_TOLERANCE") = reliability_tolerance;
    nb::class_<Colours>(m, "Colours", "Samples of a picture.")
        .def(nb::init<std::optional<ArrayIn<std::uint8_t>>, std::optional<PlanesIn>>(), nb::arg("rgb").none(),
             nb::arg("yuv").none());
    nb::class_<Source>(m, "Source")
        .def(nb::init<const Colours&, const Camera&, const Pose&, std::optional<ArrayIn<float>>, double>(),
             nb::arg("colours"), nb::arg("camera"), nb::arg("pose"), nb::arg("depth_m").none(), nb::arg("box_radius_m"))
        .def(
            "show_mirrors",
            [](Source& self, ArrayIn<float> specular, std::optional<ArrayIn<float>> virtual_depth_m) {
                self.specular = std::move(specular);
                self.virtual_depth_m = std::move(virtual_depth_m);
            },
            nb::arg("specular"), nb::arg("virtual_depth_m").none(), "Planes of SourceView, of the camera's size.");
    nb::class_<Patches>(m, "Patches")
        .def(
            "__init__",
            [](Patches* self, const Colours& colours, ArrayIn<float> depth_m, const FrameInfo& info,
               double box_radius_m) {
                const auto fits = [](const PatchAtlas& atlas, const Colours& c, const ArrayIn<float>& d) {
                    return c.fits(atlas.width(), atlas.height()) && int(d.shape(1)) == atlas.width() &&
                           int(d.shape(0)) == atlas.height();
                };
                if (!info.patches || patch_atlas_problem(*info.patches) || !fits(*info.patches, colours, depth_m))
                    throw InputError(expected_found(
                        "patches", "an atlas, and a picture and depth of its size",
                        info.patches ? "a picture or depth of another size, or a damaged atlas" : "no atlas"));
                new (self) Patches{colours, std::move(depth_m), info, box_radius_m};
            },
            nb::arg("colours"), nb::arg("depth_m"), nb::arg("info"), nb::arg("box_radius_m"));
    nb::class_<FillFrom>(m, "FillFrom", "What gaps may be filled from.")
        .def(nb::init<std::optional<Source>, std::optional<Source>, std::optional<Source>, std::optional<Patches>,
                      std::vector<Source>>(),
             nb::arg("base").none(), nb::arg("small").none(), nb::arg("hidden").none(), nb::arg("patches").none(),
             nb::arg("earlier"));
    nb::class_<Assess>(m, "Assess", "What to estimate besides colours.")
        .def(
            "__init__",
            [](Assess* self, bool reliability, bool risks, double depth_tolerance_w, const FrameInfo& info,
               const VisibleLossMeter* measured) {
                new (self) Assess{reliability, risks, depth_tolerance_w,
                                  measured != nullptr ? std::optional(measured->loss()) : visible_loss_of(info)};
            },
            nb::arg("reliability"), nb::arg("risks"), nb::arg("depth_tolerance_w"), nb::arg("info"),
            nb::arg("measured").none());
    nb::class_<DepthNeeds>(m, "DepthNeeds", "Which depth a reprojection needs.")
        .def_ro("source", &DepthNeeds::source)
        .def_ro("eye", &DepthNeeds::eye)
        .def("__bool__", &DepthNeeds::any, "Whether it needs any.")
        .def("__repr__", [](const DepthNeeds& needs) {
            const auto word = [](bool value) { return std::string(value ? "True" : "False"); };
            return "DepthNeeds(source=" + word(needs.source) + ", eye=" + word(needs.eye) + ")";
        });
    nb::class_<Reprojector>(m, "Reprojector")
        .def(nb::init<const std::string&, const std::string&, std::optional<double>, const std::string&>(),
             nb::arg("method"), nb::arg("fill"), nb::arg("error_budget_px").none(), nb::arg("mirrors"))
        .def("needs_depth", &Reprojector::needs_depth, nb::arg("source"), nb::arg("eye"))
        .def("fill_wants_depth", &Reprojector::fill_wants_depth)
        .def("reproject", &Reprojector::reproject, nb::arg("source"), nb::arg("fill_from"), nb::arg("camera"),
             nb::arg("pose"), nb::arg("depth_m").none(), nb::arg("assess"));
}

}  // namespace equistream::python
