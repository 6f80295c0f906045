#pragma once
/// The inner loops of the reliability map (reliability.cpp), for every instruction set that Highway compiles them for;
/// the one that this processor has is picked when they run. tests/support/references says in plain words what they
/// compute; tests hold one to the other. Any number of threads, each its own rows or columns.
#include "reliability.h"

#include <client/warp/eye_rays.h>
#include <client/warp/resample.h>

#include <array>
#include <cstdint>

namespace equistream {

/// Loops go by so many bytes: rows of all planes hold as many and two more, however narrow the picture.
inline constexpr int min_map_width = 32;

/// One eye whose pixels are to be judged, and planes in between, all of the picture's size and allocated by the caller.
struct MapJob {
    const RiskNumbers& numbers;
    const EyePicture& picture;  ///< its planes may be wider than `width`
    int width;
    EyeRays rays;  ///< for the specular mask
    SourceGrid grid;
    ImageView<const float> specular;              ///< of the source
    bool untouched = false;                       ///< the eye's view is the source's
    ImageView<std::uint8_t> contrast{}, along{};  ///< `along`: detail before it is spread over rows
    ImageView<std::uint8_t> filled{};             ///< steps along the column to the source, 255 where there is none
    ImageView<std::uint8_t> out{};
    ImageView<float> risks{};          ///< reliability_risks; empty where nobody asks
    ImageView<std::uint8_t> groups{};  ///< reliability_groups; with `risks`
};

/// Fills rows [first, last) of `contrast` and `along`; returns whether a pixel there is not the source's.
bool find_differences(const MapJob& job, int first, int last);
/// Fills columns [first, last) of `filled`.
void fill_columns(const MapJob& job, int first, int last);
/// Fills rows [first, last) of `out` when all of the other planes are there; `filled` may be empty where every pixel is
/// the source's.
void judge_rows(const MapJob& job, int first, int last);

}  // namespace equistream
