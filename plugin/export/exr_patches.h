#pragma once
/// A PatchAtlas as EXR attributes and back (docs/conventions.md, "EXR files").
#include "exr_attribute_values.h"

#include <equistream/patches.h>

namespace equistream {

/// Throws InputError for an atlas that is not sound.
void write_patches(AttributeWriter& out, const PatchAtlas& atlas);

bool has_patches(const AttributeReader& in);

/// All but the sphere's range, which is the camera's. `width` and `height` are the picture's; throws InputError naming
/// file and attribute.
PatchAtlas read_patches(const AttributeReader& in, int width, int height);

}  // namespace equistream
