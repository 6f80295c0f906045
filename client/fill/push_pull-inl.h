// Vectors that the loops of push_pull.h are made of. Included once for each instruction set.
#if defined(EQUISTREAM_PUSH_PULL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_PUSH_PULL_INL_H
#undef EQUISTREAM_PUSH_PULL_INL_H
#else
#define EQUISTREAM_PUSH_PULL_INL_H
#endif

#include "push_pull.h"

#include <hwy/cache_control.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A row of a tile's level 1: four cells, or four numbers of one layer.
using Tag = hn::FixedTag<float, 4>;
using Floats = hn::Vec<Tag>;
using FloatMask = hn::Mask<Tag>;
using IntTag = hn::RebindToSigned<Tag>;
constexpr Tag tag;
constexpr IntTag int_tag;
constexpr int lanes = 4;

using Layer = PullPyramid::Layer;
using Tile = PullPyramid::Tile;

HWY_INLINE Floats all(float value) {
    return hn::Set(tag, value);
}
}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#include <plugin/formulas/vectors-inl.h>

#endif
