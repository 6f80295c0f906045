#include "arrays.h"
#include "parts.h"

#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/patches.h>

#include <nanobind/stl/string.h>

namespace equistream::python {

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
                           "Which rays the pixels of an atlas of patches show: `width` x `height` pixels, each of one "
                           "of the `sphere`s that "
                           "stand at `offsets_m`. Immutable; docs/conventions.md has the whole of it.")
        .def_prop_ro("width", &PatchAtlas::width, "Columns of the atlas' picture.")
        .def_prop_ro("height", &PatchAtlas::height, "Rows of the atlas' picture.")
        .def_ro("block_side", &PatchAtlas::block_side, "Pixels that a patch is wide and high.")
        .def_prop_ro(
            "sphere", [](const PatchAtlas& atlas) { return sound(atlas).sphere(); },
            "The image of each of the spheres.")
        .def_prop_ro("offsets_m", &offsets_of, nb::sig("def offsets_m(self) -> numpy.typing.NDArray[numpy.float64]"),
                     "The spheres' places, rows of x, y, z from the main sphere's and in its camera's axes.")
        .def("samples", &samples_of, nb::sig("def samples(self) -> numpy.typing.NDArray[numpy.int32]"),
             "Of each pixel (rows x columns x 3) the sphere's number, -1 where nobody uses it, and column and row "
             "there: "
             "of blocks at the right and lower border these may be beyond the sphere's own.")
        .def("__repr__", [](const PatchAtlas& atlas) {
            return formatted("PatchAtlas(%s, %zu patches of %d pixels a side, %zu spheres)",
                             size_text(atlas.width(), atlas.height()).c_str(), atlas.used_slots(), atlas.block_side,
                             atlas.offsets_m.size());
        });
}

}  // namespace equistream::python
