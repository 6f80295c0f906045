#include "arrays.h"
#include "parts.h"

#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/frame.h>

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace equistream::python {

namespace {

constexpr double huge = std::numeric_limits<double>::max();

/// Refuses what no file could hold, with the field's name.
void set_number(double& field, const char* name, double value, std::pair<double, double> range) {
    if (!(value >= range.first && value <= range.second))
        throw InputError(expected_found(std::string("FrameInfo: ") + name,
                                        "a number from " + in_words(range.first) + " to " + in_words(range.second),
                                        in_words(value)));
    field = value;
}

void set_text(std::string& field, const char* name, const std::string& value) {
    if (value.size() > 255)
        throw InputError(
            expected_found(std::string("FrameInfo: ") + name, "at most 255 bytes", std::to_string(value.size())));
    field = value;
}

template <typename Enum, std::size_t N>
void set_word(Enum& field, const char* name, const std::string& value, const char* const (&names)[N]) {
    std::string accepted;
    for (std::size_t i = 0; i < N; ++i) {
        if (value == names[i]) {
            field = static_cast<Enum>(i);
            return;
        }
        accepted += (i == 0 ? "" : i + 1 == N ? " or " : ", ") + std::string(names[i]);
    }
    throw InputError(expected_found(std::string("FrameInfo: ") + name, accepted, "'" + value + "'"));
}

using ShareByTexture = std::array<double, CodingLoss::textures.size()>;

ShareByTexture shares_of(const CodingLoss& loss) {
    ShareByTexture shares;
    std::ranges::transform(CodingLoss::textures, shares.begin(), [&](float t) { return double(loss_at(loss, t)); });
    return shares;
}

CodingLoss coding_loss(const ShareByTexture& shares) {
    CodingLoss loss;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        double checked = 0;
        set_number(checked, "coding_loss", shares[i], {0, 1});
        loss.share_255[i] = std::uint8_t(std::lround(255 * checked));
    }
    return loss;
}

std::string repr(const FrameInfo& info) {
    const bool sphere = std::holds_alternative<EquirectCamera>(info.camera);
    const glm::dvec3& at = info.camera_pose.position_m;
    return formatted("FrameInfo(frame %lld at %g s, %s %s, %s eye at (%g, %g, %g) m, %u spp, scene '%s', host '%s')",
                     static_cast<long long>(info.index), info.time_s,
                     size_text(width_of(info.camera), height_of(info.camera)).c_str(),
                     sphere ? "equirect" : "perspective", eye_names[static_cast<int>(info.eye)], at.x, at.y, at.z,
                     info.samples_per_pixel, info.scene.c_str(), info.host.c_str());
}

}  // namespace

void bind_frame_info(nb::module_& m) {
    nb::class_<FrameInfo>(
        m, "FrameInfo",
        "Everything a client must know to use a frame: it travels in EXR attributes and inside coded pictures.")
        .def(nb::init<>())
        .def("__copy__", [](const FrameInfo& self) { return FrameInfo(self); })
        .def(
            "__deepcopy__", [](const FrameInfo& self, nb::handle) { return FrameInfo(self); }, nb::arg("memo"))
        .def_prop_rw(
            "index", [](const FrameInfo& i) { return i.index; },
            [](FrameInfo& i, std::int64_t v) {
                double checked = 0;
                set_number(checked, "index", double(v), {0, 999999999});
                i.index = v;
            },
            "Number of the frame, from 0.")
        .def_prop_rw(
            "time_s", [](const FrameInfo& i) { return i.time_s; },
            [](FrameInfo& i, double v) {
                set_number(i.time_s, "time_s", v, {-huge, huge});
            },
            "Seconds.")
        .def_prop_rw(
            "frames_per_second", [](const FrameInfo& i) { return i.frames_per_second; },
            [](FrameInfo& i, double v) {
                set_number(i.frames_per_second, "frames_per_second", v, {0.001, 1000});
            },
            "Frames a second.")
        .def_rw("camera", &FrameInfo::camera, "EquirectCamera or PerspectiveCamera.")
        .def_rw("camera_pose", &FrameInfo::camera_pose, "World from camera, at this frame.")
        .def_rw("head", &FrameInfo::head, "The head this camera was placed for.")
        .def_prop_rw(
            "eye", [](const FrameInfo& i) { return eye_names[static_cast<int>(i.eye)]; },
            [](FrameInfo& i, const std::string& v) { set_word(i.eye, "eye", v, eye_names); },
            "'centre', 'left' or 'right'.")
        .def_prop_rw(
            "ipd_m", [](const FrameInfo& i) { return i.ipd_m; },
            [](FrameInfo& i, double v) {
                set_number(i.ipd_m, "ipd_m", v, {0, 10});
            },
            "Metres between the eyes.")
        .def_prop_rw(
            "lock", [](const FrameInfo& i) { return axis_lock_names[static_cast<int>(i.lock)]; },
            [](FrameInfo& i, const std::string& v) { set_word(i.lock, "lock", v, axis_lock_names); },
            "'world': a sphere's axes are the world's; 'path': they turn with the path.")
        .def_prop_rw(
            "head_radius_m", [](const FrameInfo& i) { return i.head_radius_m; },
            [](FrameInfo& i, double v) {
                set_number(i.head_radius_m, "head_radius_m", v, {0, 1000});
            },
            "Head box: a ball of this radius around every path point.")
        .def_prop_rw(
            "exposure", [](const FrameInfo& i) { return i.exposure; },
            [](FrameInfo& i, double v) {
                set_number(i.exposure, "exposure", v, {1e-12, 1e12});
            },
            "Factor on radiance before the display transform.")
        .def_rw("seed", &FrameInfo::seed, "Of the renderer's random numbers.")
        .def_rw("samples_per_pixel", &FrameInfo::samples_per_pixel, "Of colour.")
        .def_prop_rw(
            "scene", [](const FrameInfo& i) { return i.scene; },
            [](FrameInfo& i, const std::string& v) { set_text(i.scene, "scene", v); }, "The scene's name.")
        .def_prop_rw(
            "host", [](const FrameInfo& i) { return i.host; },
            [](FrameInfo& i, const std::string& v) { set_text(i.host, "host", v); }, "The renderer's name and version.")
        .def_prop_rw(
            "geometry_fingerprint", [](const FrameInfo& i) { return i.geometry_fingerprint; },
            [](FrameInfo& i, const std::string& v) { set_text(i.geometry_fingerprint, "geometry_fingerprint", v); },
            "Names the geometry that was rendered; empty: not said.")
        .def_prop_ro(
            "box_radius_m", [](const FrameInfo& i) { return head_box_radius(i.eye, i.head_radius_m, i.ipd_m); },
            "Radius of the ball around the camera that both eyes of the head box stay in.")
        .def_prop_ro(
            "depth_tolerance_w", [](const FrameInfo& i) { return depth_tolerance_w(i.depth_code); },
            "What the code of the depth that came with a picture may put it off by, in w; 0: it is the renderer's own.")
        .def_prop_rw(
            "crf", [](const FrameInfo& i) { return i.crf; },
            [](FrameInfo& i, std::optional<double> v) {
                double checked = 0;
                if (v)
                    set_number(checked, "crf", *v, {0, worst_crf});
                i.crf = v ? std::optional(float(*v)) : std::nullopt;
            },
            nb::for_setter(nb::arg("value").none()),
            "Quality that the picture's track of a stream was coded at, 0 (best) to 51; None: not coded, without loss, "
            "or not said.")
        .def_prop_rw(
            "coding_loss",
            [](const FrameInfo& i) { return i.coding_loss ? std::optional(shares_of(*i.coding_loss)) : std::nullopt; },
            [](FrameInfo& i, const std::optional<ShareByTexture>& v) {
                i.coding_loss = v ? std::optional(coding_loss(*v)) : std::nullopt;
            },
            nb::for_setter(nb::arg("value").none()),
            "What that took from the colours as the encoder measured it: shares of pixels that are off by more than "
            "RELIABILITY_TOLERANCE, where the decoded picture's texture is CODING_TEXTURES; None: nobody said.")
        .def_ro(
            "moving", &FrameInfo::moving, nb::rv_policy::copy,
            "List of MovingRegion: what of a stream's main picture moves by itself; empty: nothing, or nobody said.")
        .def_ro("patches", &FrameInfo::patches, nb::rv_policy::copy,
                "PatchAtlas of an atlas' picture, which then has the pose of the sphere that its patches are beside; "
                "else None.")
        .def("__repr__", &repr);
    m.attr("CODING_TEXTURES") = nb::cast(CodingLoss::textures);
    m.def(
        "eye_pose",
        [](const Camera& camera, const Pose& head, const std::string& eye, double ipd_m, const std::string& lock) {
            Eye which{};
            AxisLock axes{};
            set_word(which, "eye", eye, eye_names);
            set_word(axes, "lock", lock, axis_lock_names);
            return camera_pose(camera, head, which, ipd_m, axes);
        },
        nb::arg("camera"), nb::arg("head"), nb::arg("eye") = "centre", nb::arg("ipd_m") = default_ipd_m,
        nb::arg("lock") = "world",
        "The pose a camera has for a head: at the eye; turned with the head, unless it is a world-locked sphere.");
}

}  // namespace equistream::python
