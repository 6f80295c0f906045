// Vectors that the loops of push_pull.h are made of: one layer of four cells at once. Included once for each
// instruction set.
#if defined(EQUISTREAM_PUSH_PULL_LAYERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_PUSH_PULL_LAYERS_INL_H
#undef EQUISTREAM_PUSH_PULL_LAYERS_INL_H
#else
#define EQUISTREAM_PUSH_PULL_LAYERS_INL_H
#endif

#include "push_pull.h"

#include <hwy/highway.h>

#include <array>
#include <cstdint>
#include <limits>

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

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

HWY_INLINE FloatMask never() {
    return all(0) > all(1);
}
HWY_INLINE FloatMask mask_of(bool set) {
    return all(set ? 1.0f : 0.0f) > all(0);
}

/// One layer of four cells.
struct Layers {
    Floats r, g, b, w;
    FloatMask present, coloured;  ///< coloured: only where present
};

HWY_INLINE Layers no_layers() {
    return {all(0), all(0), all(0), all(0), never(), never()};
}

/// Of layers that are there and have a colour.
template <std::size_t Children>
HWY_INLINE Layers mean_of(const std::array<Layers, Children>& children) {
    Layers sum = children[0];
    for (std::size_t i = 1; i < Children; ++i) {
        sum.r = sum.r + children[i].r;
        sum.g = sum.g + children[i].g;
        sum.b = sum.b + children[i].b;
        sum.w = sum.w + children[i].w;
    }
    const Floats share = all(1 / float(Children));
    return {sum.r * share, sum.g * share, sum.b * share, sum.w * share, sum.present, sum.coloured};
}

/// The pull of push_pull.h: far and near.
template <std::size_t Children>
HWY_INLINE std::array<Layers, 2> pulled(const std::array<Layers, Children>& children, float tolerance) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Floats low = all(infinity), high = all(-infinity);
    for (const Layers& child : children) {
        low = hn::Min(low, hn::IfThenElse(child.present, child.w, all(infinity)));
        high = hn::Max(high, hn::IfThenElse(child.present, child.w, all(-infinity)));
    }
    const FloatMask alike = high - low <= all(tolerance);
    FloatMask coloured_all = children[0].coloured;
    for (const Layers& child : children)
        coloured_all = hn::And(coloured_all, child.coloured);
    if (hn::AllTrue(tag, hn::And(alike, coloured_all)))
        return {mean_of(children), no_layers()};
    const Floats split = formulas::split_between(low, high, tolerance);
    std::array<Layers, 2> halves;
    for (int half = 0; half < 2; ++half) {
        Layers& sum = halves[std::size_t(half)];
        sum = no_layers();
        if (half == 1 && hn::AllTrue(tag, alike))
            break;
        Floats present = all(0), coloured = all(0);
        for (const Layers& child : children) {
            const FloatMask here = hn::And(child.present, half == 0 ? child.w <= split : child.w > split);
            const FloatMask shown = hn::And(here, child.coloured);
            present = present + hn::IfThenElseZero(here, all(1));
            coloured = coloured + hn::IfThenElseZero(shown, all(1));
            sum.w = sum.w + hn::IfThenElseZero(here, child.w);
            sum.r = sum.r + hn::IfThenElseZero(shown, child.r);
            sum.g = sum.g + hn::IfThenElseZero(shown, child.g);
            sum.b = sum.b + hn::IfThenElseZero(shown, child.b);
        }
        sum.present = present > all(0);
        sum.coloured = coloured > all(0);
        const Floats scale = all(1) / hn::Max(coloured, all(1));
        sum.w = sum.w / hn::Max(present, all(1));
        sum.r = sum.r * scale;
        sum.g = sum.g * scale;
        sum.b = sum.b * scale;
    }
    return halves;
}

HWY_INLINE unsigned bits_of(FloatMask mask) {
    std::uint8_t bits[8];
    hn::StoreMaskBits(tag, mask, bits);
    return bits[0];
}

/// Four cells of a level from the `first` on.
template <std::size_t Cells>
HWY_INLINE void store(const std::array<Layers, 2>& halves, PullPyramid::Layers<Cells>& to, PullPyramid::LayerBits& bits,
                      int first) {
    for (std::size_t half = 0; half < 2; ++half) {
        const unsigned present = bits_of(halves[half].present);
        if (first == 0)
            bits[half] = {};
        if (present == 0)
            continue;
        bits[half].present = std::uint16_t(bits[half].present | present << first);
        bits[half].coloured = std::uint16_t(bits[half].coloured | bits_of(halves[half].coloured) << first);
        hn::StoreInterleaved4(halves[half].r, halves[half].g, halves[half].b, halves[half].w, tag,
                              &to[half][std::size_t(first)].r);
    }
}

/// Of cells that are four times the same.
HWY_INLINE void store_one(const std::array<Layers, 2>& halves, PullPyramid::OneCell& cell) {
    PullPyramid::Layers<4> four;
    store(halves, four, cell.bits, 0);
    for (std::size_t half = 0; half < 2; ++half) {
        cell.layers[half][0] = four[half][0];
        cell.bits[half] = {std::uint16_t(cell.bits[half].present & 1), std::uint16_t(cell.bits[half].coloured & 1)};
    }
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
