#pragma once
/// The sRGB transfer curve (IEC 61966-2-1) on values from 0 to 1, per channel. Pure functions.
#include <plugin/formulas/scalars.h>

namespace equistream {

using formulas::linear_to_srgb;
using formulas::srgb_to_linear;

}  // namespace equistream
