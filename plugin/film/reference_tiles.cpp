#include "reference_tiles.h"

#include "sampling.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace equistream {
namespace {

constexpr double share_of_samples = 0.02;
/// Of both halves together.
constexpr std::uint32_t times_the_samples = 64;
constexpr std::uint32_t fewest_samples = 256;
/// Additive recurrence of the plastic number's powers: the points of any run are spread evenly over the square
/// (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
constexpr double step_x = 0.7548776662466927, step_y = 0.5698402909980532;

int at(double from_0_to_1, int cells) {
    return std::min(static_cast<int>(from_0_to_1 * cells), cells - 1) * ReferenceTiles::side;
}

}  // namespace

ReferenceTiles reference_tiles(glm::ivec2 size, std::uint32_t samples_per_pixel, std::uint32_t accumulated_frames,
                               std::int64_t frame_index) {
    const glm::ivec2 cells = (size + ReferenceTiles::side - 1) / ReferenceTiles::side;
    ReferenceTiles tiles;
    const std::uint64_t samples =
        std::uint64_t{times_the_samples} * samples_per_pixel * std::max(accumulated_frames, 1u);
    tiles.samples = std::uint32_t(std::clamp<std::uint64_t>(samples, fewest_samples, geometry_sample - 1));
    const double all = double(size.x) * size.y * samples_per_pixel;
    const double each = double(ReferenceTiles::pixels) * tiles.samples;
    const auto count = std::max<std::int64_t>(std::llround(share_of_samples * all / each), 1);
    std::set<std::pair<int, int>> taken;
    for (std::int64_t i = 0; i < count; ++i) {
        const double point = double(frame_index % 1000003) * double(count) + double(i);
        double whole = 0;
        const glm::ivec2 corner(at(std::modf(0.5 + point * step_x, &whole), cells.x),
                                at(std::modf(0.5 + point * step_y, &whole), cells.y));
        if (taken.emplace(corner.x, corner.y).second)
            tiles.corners.push_back(corner);
    }
    return tiles;
}

}  // namespace equistream
