#include "bindings.h"

#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/frame.h>
#include <equistream/object_motion.h>
#include <equistream/patches.h>
#include <equistream/text.h>

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <cmath>

namespace equistream::python {

namespace {

/// Refuses what no file could hold, with the field's name.
void set_number(double& field, const char* name, double value, std::pair<double, double> range) {
    if (!(value >= range.first && value <= range.second))
        throw InputError(expected_found(std::string("FrameInfo: ") + name,
                                        "a number from " + in_words(range.first) + " to " + in_words(range.second),
                                        in_words(value)));
    field = value;
}

void set_text(std::string& field, const char* name, const std::string& value) {
    if (value.size() > max_name_bytes)
        throw InputError(
            expected_found(std::string("FrameInfo: ") + name, "at most 255 bytes", std::to_string(value.size())));
    field = value;
}

template <typename Enum, std::size_t N>
void set_word(Enum& field, const char* name, const std::string& value, const char* const (&names)[N]) {
    const auto found = std::find(std::begin(names), std::end(names), value);
    if (found == std::end(names))
        throw InputError(
            expected_found(std::string("FrameInfo: ") + name, in_a_sentence(names, " or "), "'" + value + "'"));
    field = static_cast<Enum>(found - names);
}

using ShareByTexture = std::array<double, VisibleLoss::textures.size()>;

ShareByTexture shares_of(const VisibleLoss& loss) {
    ShareByTexture shares;
    std::ranges::transform(VisibleLoss::textures, shares.begin(), [&](float t) { return double(loss_at(loss, t)); });
    return shares;
}

VisibleLoss visible_loss(const ShareByTexture& shares) {
    VisibleLoss loss;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        double checked = 0;
        set_number(checked, "visible_loss", shares[i], {0, 1});
        loss.share_255[i] = std::uint8_t(std::lround(255 * checked));
    }
    return loss;
}

void require_same_size(const ArrayIn<std::uint8_t>& a, const ArrayIn<std::uint8_t>& b) {
    if (a.shape(0) != b.shape(0) || a.shape(1) != b.shape(1) || a.shape(2) < 3 || b.shape(2) < 3)
        throw InputError(expected_found("VisibleLossMeter", "two pictures of one size, RGB or RGBA",
                                        size_text(int(a.shape(1)), int(a.shape(0))) + " and " +
                                            size_text(int(b.shape(1)), int(b.shape(0)))));
}

std::string repr(const FrameInfo& info) {
    const char* const camera = std::holds_alternative<PerspectiveCamera>(info.camera) ? "perspective"
                               : is_ods(info.camera)                                  ? "ods"
                                                                                      : "equirect";
    const glm::dvec3& at = info.camera_pose.position_m;
    return formatted("FrameInfo(frame %lld at %g s, %s %s, %s eye at (%g, %g, %g) m, %u spp, scene '%s', host '%s')",
                     static_cast<long long>(info.index), info.time_s,
                     size_text(width_of(info.camera), height_of(info.camera)).c_str(), camera,
                     eye_names[static_cast<int>(info.eye)], at.x, at.y, at.z, info.samples_per_pixel,
                     info.scene.c_str(), info.host.c_str());
}

}  // namespace

void bind_frame_info(nb::module_& m) {
    nb::class_<FrameInfo> info(
        m, "FrameInfo",
        "Everything a client must know to use a frame: it travels in EXR attributes and inside coded pictures.");
    const auto number = [&](const char* name, double FrameInfo::*field, std::pair<double, double> range,
                            const char* help) {
        info.def_prop_rw(
            name, [=](const FrameInfo& i) { return i.*field; },
            [=](FrameInfo& i, double v) { set_number(i.*field, name, v, range); }, help);
    };
    const auto text = [&](const char* name, std::string FrameInfo::*field, const char* help) {
        info.def_prop_rw(
            name, [=](const FrameInfo& i) { return i.*field; },
            [=](FrameInfo& i, const std::string& v) { set_text(i.*field, name, v); }, help);
    };
    const auto word = [&](const char* name, auto field, const auto& names, const char* help) {
        info.def_prop_rw(
            name, [field, &names](const FrameInfo& i) { return names[static_cast<int>(i.*field)]; },
            [name, field, &names](FrameInfo& i, const std::string& v) { set_word(i.*field, name, v, names); }, help);
    };
    info.def(nb::init<>())
        .def("__copy__", [](const FrameInfo& self) { return FrameInfo(self); })
        .def(
            "__deepcopy__", [](const FrameInfo& self, nb::handle) { return FrameInfo(self); }, nb::arg("memo"))
        .def_prop_rw(
            "index", [](const FrameInfo& i) { return i.index; },
            [](FrameInfo& i, std::int64_t v) {
                double checked = 0;
                set_number(checked, "index", double(v), {0, max_frame_index});
                i.index = v;
            },
            "Number of the frame, from 0.");
    number("time_s", &FrameInfo::time_s, {-max_time_s, max_time_s}, "Seconds.");
    number("frames_per_second", &FrameInfo::frames_per_second, {0.001, 1000}, "Frames a second.");
    // Copies: what was read stays as it is when another is set.
    const nb::for_getter copied(nb::rv_policy::copy);
    info.def_rw("camera", &FrameInfo::camera, copied, "EquirectCamera or PerspectiveCamera.")
        .def_rw("camera_pose", &FrameInfo::camera_pose, copied, "World from camera, at this frame.")
        .def_rw("head", &FrameInfo::head, copied, "The head this camera was placed for.");
    word("eye", &FrameInfo::eye, eye_names, "'centre', 'left' or 'right'.");
    number("ipd_m", &FrameInfo::ipd_m, {0, 10}, "Metres between the eyes.");
    word("lock", &FrameInfo::lock, axis_lock_names,
         "'world': a sphere's axes are the world's; 'path': they turn with the path.");
    number("head_radius_m", &FrameInfo::head_radius_m, {0, 1000},
           "Head box: a ball of this radius around every path point.");
    number("exposure", &FrameInfo::exposure, {1e-12, 1e12}, "Factor on radiance before the display transform.");
    info.def_rw("seed", &FrameInfo::seed, "Seed of the renderer's random numbers.")
        .def_rw("samples_per_pixel", &FrameInfo::samples_per_pixel, "Samples per pixel of colour.");
    text("scene", &FrameInfo::scene, "The scene's name.");
    text("host", &FrameInfo::host, "The renderer's name and version.");
    text("geometry_fingerprint", &FrameInfo::geometry_fingerprint,
         "Identifies the geometry that was rendered; empty: not known.");
    text("denoiser", &FrameInfo::denoiser, "The denoiser of colour; empty: not denoised.");
    info.def_prop_ro(
            "packing", [](const FrameInfo& i) { return packing_names[static_cast<int>(i.packing)]; },
            "How both eyes lie in the picture of a stream: 'none', 'sbs' or 'top-bottom'.")
        .def_prop_ro(
            "box_radius_m", [](const FrameInfo& i) { return head_box_radius(i.eye, i.head_radius_m, i.ipd_m); },
            "Radius of the ball around the camera that both eyes of the head box stay in.")
        .def_prop_ro(
            "depth_tolerance_w", [](const FrameInfo& i) { return depth_tolerance_w(i.depth_code); },
            "How far the depth code may shift the received depth, in w (docs/conventions.md); 0: the renderer's own "
            "depth.")
        .def_prop_rw(
            "crf", [](const FrameInfo& i) { return i.crf; },
            [](FrameInfo& i, std::optional<double> v) {
                double checked = 0;
                if (v)
                    set_number(checked, "crf", *v, {0, worst_crf});
                i.crf = v ? std::optional(float(*v)) : std::nullopt;
            },
            nb::for_setter(nb::arg("value").none()),
            "Quality (CRF) at which the picture's track was coded, 0 (best) to 51; None: not coded, lossless or not "
            "known.")
        .def_prop_rw(
            "visible_loss",
            [](const FrameInfo& i) {
                return i.visible_loss ? std::optional(shares_of(*i.visible_loss)) : std::nullopt;
            },
            [](FrameInfo& i, const std::optional<ShareByTexture>& v) {
                i.visible_loss = v ? std::optional(visible_loss(*v)) : std::nullopt;
            },
            nb::for_setter(nb::arg("value").none()),
            "Visible error of the colours, as the encoder measured it: for each of CODING_TEXTURES, the share of "
            "pixels whose error exceeds RELIABILITY_TOLERANCE. None: not measured.")
        .def_ro("moving", &FrameInfo::moving, nb::rv_policy::copy,
                "List of MovingRegion: the moving objects in a stream's main picture; empty: none, or not known.")
        .def_ro("patches", &FrameInfo::patches, nb::rv_policy::copy,
                "PatchAtlas of a picture of patches, whose pose is that of the main sphere; else None.")
        .def("__repr__", &repr);
    nb::class_<VisibleLossMeter>(m, "VisibleLossMeter",
                                 "Measures the visible error of pictures by the texture around their pixels. Pictures "
                                 "are display-referred, 8 bits.")
        .def(nb::init<>())
        .def(
            "add",
            [](VisibleLossMeter& meter, const ArrayIn<std::uint8_t>& picture, const ArrayIn<std::uint8_t>& decoded) {
                require_same_size(picture, decoded);
                meter.add(view_of(picture), view_of(decoded));
            },
            nb::arg("picture"), nb::arg("decoded"), "One picture before and after coding.")
        .def(
            "add_reference",
            [](VisibleLossMeter& meter, const ArrayIn<std::uint8_t>& shown, const ArrayIn<std::uint8_t>& reference,
               const ArrayIn<std::uint8_t>& repeat) {
                require_same_size(shown, reference);
                require_same_size(shown, repeat);
                if (reference.shape(2) != 4)
                    throw InputError(
                        expected_found("reference", "RGBA", std::to_string(reference.shape(2)) + " channels"));
                meter.add_reference(view_of(shown), view_of(reference), view_of(repeat));
            },
            nb::arg("shown"), nb::arg("reference"), nb::arg("repeat"),
            "The picture shown; its reference, RGBA of the same size, valid where A is not 0; and the reference again "
            "with independent noise.")
        .def(
            "loss", [](const VisibleLossMeter& meter) { return shares_of(meter.loss()); },
            "For each of CODING_TEXTURES, the share of pixels whose error exceeds RELIABILITY_TOLERANCE. Measured by "
            "the references; where these are too few, at least the share that coding caused. Without references, the "
            "share that coding caused.");
    m.attr("CODING_TEXTURES") = nb::cast(VisibleLoss::textures);
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
        "The camera's pose for a head: at the eye, and turned with the head unless it is a world-locked sphere.");
}

namespace {

const PatchAtlas& sound(const PatchAtlas& atlas) {
    if (const auto problem = patch_atlas_problem(atlas))
        throw InputError("PatchAtlas: " + *problem);
    return atlas;
}

nb::object offsets_of(const PatchAtlas& atlas) {
    auto owned = std::make_unique<double[]>(atlas.offsets_m.size() * 3);
    double* const data = owned.get();
    const nb::capsule owner(owned.release(), [](void* p) noexcept { delete[] static_cast<double*>(p); });
    for (std::size_t i = 0; i < atlas.offsets_m.size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
            data[3 * i + std::size_t(axis)] = atlas.offsets_m[i][axis];
    const std::size_t shape[] = {atlas.offsets_m.size(), 3};
    return nb::cast(nb::ndarray<nb::numpy, double>(data, 2, shape, owner));
}

/// Of each pixel: which sphere it is of, -1 in slots that nobody uses, and the column and row it has there.
nb::object samples_of(const PatchAtlas& atlas) {
    sound(atlas);
    Image<std::int32_t> samples(atlas.width(), atlas.height(), 3);
    for (int y = 0; y < atlas.height(); ++y)
        for (int x = 0; x < atlas.width(); ++x) {
            const PatchAtlas::Slot& slot = atlas.slot_at(x, y);
            const PixelCoordinates<double> at = patch_sphere_pixel(atlas, x, y, x, y);
            std::int32_t* sample = samples.pixel(x, y);
            sample[0] = slot.used ? slot.offset_index : -1;
            sample[1] = static_cast<std::int32_t>(at.u);
            sample[2] = static_cast<std::int32_t>(at.v);
        }
    return to_array(std::move(samples));
}

}  // namespace

void bind_patches(nb::module_& m) {
    nb::class_<PatchAtlas>(m, "PatchAtlas",
                           "The rays that the pixels of an atlas of patches show: `width` x `height` pixels, each of "
                           "one of the `sphere`s at `offsets_m`. Immutable. Format: docs/stream-format.md.")
        .def_prop_ro("width", &PatchAtlas::width, "Columns of the atlas' picture.")
        .def_prop_ro("height", &PatchAtlas::height, "Rows of the atlas' picture.")
        .def_ro("block_side", &PatchAtlas::block_side, "Side of a patch, in pixels.")
        .def_prop_ro(
            "sphere", [](const PatchAtlas& atlas) { return sound(atlas).sphere(); }, "The camera of each sphere.")
        .def_prop_ro("offsets_m", &offsets_of, nb::sig("def offsets_m(self) -> numpy.typing.NDArray[numpy.float64]"),
                     "Positions of the spheres, rows of x, y, z: relative to the main sphere, in its camera's axes.")
        .def("samples", &samples_of, nb::sig("def samples(self) -> numpy.typing.NDArray[numpy.int32]"),
             "For each pixel (rows x columns x 3) the sphere's number, -1 where unused, and the column and row there. "
             "In blocks at the right and lower border these may lie outside the sphere.")
        .def("__repr__", [](const PatchAtlas& atlas) {
            return formatted("PatchAtlas(%s, %zu patches of %d pixels a side, %zu spheres)",
                             size_text(atlas.width(), atlas.height()).c_str(), atlas.used_slots(), atlas.block_side,
                             atlas.offsets_m.size());
        });
}

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
            "v of the twist: a point at p has the velocity v + w x p.")
        .def_prop_ro(
            "angular_rad_s", [](const MovingRegion& r) { return triple(r.motion.twist.angular_rad_s); },
            "w of the twist.")
        .def_prop_ro(
            "velocity_per_second", [](const MovingRegion& r) { return triple(r.motion.twist_per_second.velocity_m_s); },
            "Rate of change of v.")
        .def_prop_ro(
            "angular_per_second", [](const MovingRegion& r) { return triple(r.motion.twist_per_second.angular_rad_s); },
            "Rate of change of w.")
        .def_ro("near_m", &MovingRegion::near_m, "Distance from the camera to its nearest surface point.")
        .def_ro("far_m", &MovingRegion::far_m, "Distance to the farthest.")
        .def_prop_ro("pixels", &MovingRegion::pixels, "Number of pixels that show it.")
        .def("mask", &mask_of, nb::arg("width"), nb::arg("height"),
             nb::sig("def mask(self, width: int, height: int) -> numpy.typing.NDArray[numpy.uint8]"),
             "1 where the picture shows it; the size must be that of the picture.")
        .def("movement", &movement_of, nb::arg("seconds"),
             "Its motion over so many seconds: a 3 x 4 matrix that maps (p, 1) to the new position.")
        .def("__repr__", [](const MovingRegion& r) {
            return formatted("MovingRegion(%lld pixels, %g to %g m away)", static_cast<long long>(r.pixels()),
                             double(r.near_m), double(r.far_m));
        });
}

}  // namespace equistream::python
