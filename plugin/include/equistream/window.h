#pragma once
/// A window: the region of a dense sphere around the gaze. The whole sphere around it, the base, has fewer pixels.
///
/// A window is a rectangle of pixels of a full sphere of `columns` x `rows`, the grid, which is fixed to the sphere's
/// axes. It lies on whole blocks of the grid, so that a codec predicts still content exactly while the window moves. It
/// may cross the seam, and never a pole. Everything is a plain value; all functions are pure and thread-safe.
#include <equistream/bound.h>
#include <equistream/camera.h>
#include <equistream/error.h>
#include <equistream/image.h>
#include <equistream/text.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>

namespace equistream {

/// Step of a window's position and size, in pixels: a macroblock of H.264.
inline constexpr int window_block_px = 16;

/// Sizes that all windows of a sequence share, in pixels.
struct WindowGrid {
    int columns = 0, rows = 0;  ///< of the whole sphere; rows are half the columns
    int width = 0, height = 0;  ///< of the window
    bool operator==(const WindowGrid&) const = default;
};

/// A window's upper left corner on the grid: x in [0, columns), y in [0, rows - height].
struct WindowPlace {
    int x = 0, y = 0;
    bool operator==(const WindowPlace&) const = default;
};

/// What is wrong with a grid, in words; nullopt if it is valid. `columns` must be a multiple of 16 and twice the rows.
/// A window is a whole number of blocks wide and high, narrower than the sphere and at most as high.
inline std::optional<std::string> window_grid_problem(const WindowGrid& grid) {
    const auto is_blocks = [](int pixels) { return pixels > 0 && pixels % window_block_px == 0; };
    if (!is_blocks(grid.columns) || grid.rows * 2 != grid.columns)
        return expected_found("density", "columns of a sphere in multiples of 16, twice its rows",
                              size_text(grid.columns, grid.rows));
    if (!is_blocks(grid.width) || !is_blocks(grid.height))
        return expected_found("window", "a width and a height in multiples of 16 pixels",
                              size_text(grid.width, grid.height));
    if (grid.width >= grid.columns || grid.height > grid.rows)
        return expected_found("window", "less than the sphere's " + size_text(grid.columns, grid.rows),
                              size_text(grid.width, grid.height));
    return std::nullopt;
}

/// The grid whose window covers at least these angles, rounded up to whole blocks and limited to the sphere. It may be
/// invalid: check window_grid_problem().
inline WindowGrid window_grid(int columns, double width_rad, double height_rad) {
    const auto blocks = [&](double angle_rad, int most) {
        const double pixels = std::clamp(angle_rad * columns / (2 * pi), 0.0, double(most));
        return int(std::ceil(pixels / window_block_px - 1e-9)) * window_block_px;
    };
    return {columns, columns / 2, blocks(width_rad, columns), std::min(blocks(height_rad, columns / 2), columns / 2)};
}

/// So many times a live stream's window may have half of its pixels, where its line is too narrow for all. A third time
/// gains 0.06 dB (docs/decisions/0018).
inline constexpr int most_window_halvings = 2;

/// The grid whose window covers at least the same angles with its pixels halved so many times: by a factor of sqrt(2)
/// along each side, rounded to whole blocks.
inline WindowGrid halved_window_grid(const WindowGrid& grid, int halvings) {
    constexpr int step = 2 * window_block_px;
    const int columns = step * int(std::lround(grid.columns * std::exp2(-0.5 * halvings) / step));
    // A side of whole blocks stays so: rounding must not add another.
    const auto angle = [&](int side) { return (side - 1e-6) * 2 * pi / grid.columns; };
    return window_grid(columns, angle(grid.width), angle(grid.height));
}

/// Longitudes and latitudes of a window. Longitudes lie from -2 pi to 2 pi, within the limits of camera_limits.h.
inline LongitudeLatitudeRange window_range(const WindowGrid& grid, WindowPlace place) {
    const double step = 2 * pi / grid.columns;
    LongitudeLatitudeRange range;
    range.longitude_min = place.x * step - pi;
    range.longitude_max = (place.x + grid.width) * step - pi;
    if (range.longitude_max > 2 * pi) {
        range.longitude_min -= 2 * pi;
        range.longitude_max -= 2 * pi;
    }
    range.latitude_max = pi / 2 - place.y * step;
    range.latitude_min = pi / 2 - (place.y + grid.height) * step;
    return range;
}

/// The full sphere, whose first column is at -180 degrees: as windows count its columns.
inline bool is_centred_full_sphere(const LongitudeLatitudeRange& range) {
    return range.is_full_sphere() && std::abs(range.longitude_min + pi) < 1e-9;
}

inline EquirectCamera window_camera(const WindowGrid& grid, WindowPlace place) {
    return {grid.width, grid.height, window_range(grid, place)};
}

/// Copies a window's pixels from a picture of the whole sphere, or nothing from an empty one. The window does not cross
/// the seam.
template <typename Sample>
Image<Sample> window_pixels(const Image<Sample>& sphere, const WindowGrid& grid, WindowPlace place) {
    if (sphere.empty())
        return {};
    Image<Sample> part(grid.width, grid.height, sphere.channels());
    for (int y = 0; y < grid.height; ++y)
        std::copy_n(sphere.pixel(place.x, place.y + y), grid.width * sphere.channels(), part.view().row(y));
    return part;
}

/// A camera for a window straight ahead: it stands for all windows of a sequence in the manifest.
inline EquirectCamera window_shape(const WindowGrid& grid) {
    const double half_width = grid.width * pi / grid.columns, half_height = grid.height * pi / grid.columns;
    return {grid.width, grid.height, {-half_width, half_width, -half_height, half_height}};
}

/// What is wrong with a place, in words; nullopt if a window may be there.
inline std::optional<std::string> window_place_problem(const WindowGrid& grid, WindowPlace place) {
    const auto is_block = [](int corner, int last) {
        return corner >= 0 && corner <= last && corner % window_block_px == 0;
    };
    if (is_block(place.x, grid.columns - 1) && is_block(place.y, grid.rows - grid.height))
        return std::nullopt;
    return expected_found("window_x, window_y",
                          "multiples of 16, up to " + std::to_string(grid.columns - window_block_px) + " and " +
                              std::to_string(grid.rows - grid.height),
                          std::to_string(place.x) + ", " + std::to_string(place.y));
}

/// The inverse of window_range; nullopt for a range that no window of the grid has (within 1e-9 radians).
inline std::optional<WindowPlace> window_place(const WindowGrid& grid, const LongitudeLatitudeRange& range) {
    const double step = 2 * pi / grid.columns;
    const auto column = static_cast<int>(std::lround((range.longitude_min + pi) / step));
    const WindowPlace place{(column % grid.columns + grid.columns) % grid.columns,
                            static_cast<int>(std::lround((pi / 2 - range.latitude_max) / step))};
    const LongitudeLatitudeRange there = window_range(grid, place);
    const auto same = [](double a, double b) { return std::abs(a - b) < 1e-9; };
    if (window_place_problem(grid, place) || !same(there.longitude_min, range.longitude_min) ||
        !same(there.longitude_max, range.longitude_max) || !same(there.latitude_min, range.latitude_min) ||
        !same(there.latitude_max, range.latitude_max))
        return std::nullopt;
    return place;
}

/// The window, on whole blocks, whose middle is nearest to `gaze`, a direction in the sphere's axes.
inline WindowPlace window_around(const WindowGrid& grid, const glm::dvec3& gaze) {
    const EquirectCamera sphere{grid.columns, grid.rows, {}};
    const glm::dvec2 middle = sphere.pixel(gaze);
    const auto snap = [](double pixel) { return int(std::lround(pixel / window_block_px)) * window_block_px; };
    const int x = snap(middle.x - 0.5 * grid.width), y = snap(middle.y - 0.5 * grid.height);
    return {((x % grid.columns) + grid.columns) % grid.columns,
            std::clamp(y, 0, (grid.rows - grid.height) / window_block_px * window_block_px)};
}

/// Moves a window with a gaze: it stays until the gaze is farther than slack_px() from its middle, and is then centred
/// on the gaze. One object for each gaze; one thread.
class WindowFollower {
public:
    explicit WindowFollower(const WindowGrid& grid) : grid_(grid) {}

    /// Largest distance of the gaze from the window's middle along a side, in pixels: an eighth of the side, and at
    /// least a block, so that the window does not jitter.
    static int slack_px(int side) { return std::max(side / 8, window_block_px); }

    const WindowGrid& grid() const { return grid_; }
    /// The window for this gaze, a direction in the sphere's axes.
    WindowPlace place(const glm::dvec3& gaze) {
        const WindowPlace wanted = window_around(grid_, gaze);
        if (!place_ || distance(wanted.x, place_->x) > slack_px(grid_.width) ||
            std::abs(wanted.y - place_->y) > slack_px(grid_.height))
            place_ = wanted;
        return *place_;
    }

private:
    int distance(int a, int b) const {
        const int apart = std::abs(a - b);
        return std::min(apart, grid_.columns - apart);
    }

    WindowGrid grid_;
    std::optional<WindowPlace> place_;
};

// Tiles: adjacent windows that together cover a denser sphere. A server sends each viewer the tiles in its view.

/// Number of tiles across and down.
struct TileGrid {
    int columns = 0, rows = 0;
    int count() const { return columns * rows; }
    bool operator==(const TileGrid&) const = default;
};

/// Sizes of the tiles of a sphere with so many columns. All tiles have one size.
inline WindowGrid tile_grid(int sphere_columns, const TileGrid& tiles) {
    return {sphere_columns, sphere_columns / 2, sphere_columns / tiles.columns, sphere_columns / 2 / tiles.rows};
}
/// Upper left corner of a tile. Tiles are numbered from 0, row by row from the top, left to right.
inline WindowPlace tile_place(const WindowGrid& grid, const TileGrid& tiles, int tile) {
    return {tile % tiles.columns * grid.width, tile / tiles.columns * grid.height};
}

/// What is wrong with a grid of tiles, in words; nullopt if it is valid.
inline std::optional<std::string> tile_problem(int sphere_columns, const TileGrid& tiles) {
    if (tiles.columns < 2 || tiles.rows < 1)
        return expected_found("tiles", "at least 2 across and 1 down", size_text(tiles.columns, tiles.rows));
    const WindowGrid grid = tile_grid(sphere_columns, tiles);
    const bool whole = grid.width * tiles.columns == grid.columns && grid.height * tiles.rows == grid.rows;
    if (whole && !window_grid_problem(grid))
        return std::nullopt;
    return expected_found("tiles",
                          "numbers that divide " + size_text(grid.columns, grid.rows) + " pixels into multiples of 16",
                          size_text(tiles.columns, tiles.rows));
}

/// A tile's position in its sphere.
struct TilePart {
    TileGrid grid;
    WindowGrid windows;  ///< size of the sphere and of a tile, in pixels
    WindowPlace place;
    bool is_of_same_sphere(const TilePart& other) const { return grid == other.grid && windows == other.windows; }
    int number() const { return place.y / windows.height * grid.columns + place.x / windows.width; }
};

/// The inverse of tile_grid and tile_place; nullopt for a camera that is no tile of a sphere within image.h's limits.
inline std::optional<TilePart> tile_part(const EquirectCamera& camera) {
    const double across = 2 * pi / camera.range.longitude_span(), down = pi / camera.range.latitude_span();
    if (!(across * camera.width <= max_image_side && down <= max_image_side))
        return std::nullopt;
    TilePart part{{int(std::lround(across)), int(std::lround(down))}, {}, {}};
    const int columns = camera.width * part.grid.columns;
    if (tile_problem(columns, part.grid))
        return std::nullopt;
    part.windows = tile_grid(columns, part.grid);
    const auto place = window_place(part.windows, camera.range);
    if (part.windows.height != camera.height || !place || place->x % part.windows.width != 0 ||
        place->y % part.windows.height != 0)
        return std::nullopt;
    part.place = *place;
    return part;
}

/// Extent of a symmetric view: the tangents of half its horizontal and half its vertical field of view.
struct ViewExtent {
    double half_width = 1, half_height = 1;
    bool operator==(const ViewExtent&) const = default;
};
inline ViewExtent extent_of(const PerspectiveCamera& view) {
    const double focal_px = view.focal_px();
    return {0.5 * view.width / focal_px, 0.5 * view.height / focal_px};
}
/// The extent widened by `guard_rad` at each side, to at most 89 degrees from the axis.
inline ViewExtent widened(const ViewExtent& extent, double guard_rad) {
    constexpr double widest_rad = 89 * pi / 180;
    const auto wider = [&](double tangent) { return std::tan(std::min(std::atan(tangent) + guard_rad, widest_rad)); };
    return {wider(extent.half_width), wider(extent.half_height)};
}

/// Adds the numbers of the tiles in a view to `seen`. `sphere_from_view` rotates directions from the view's axes to the
/// sphere's. It samples the view by rays that are at most half a tile apart. Tiles meet in a point at each pole, which
/// it tests separately.
inline void add_tiles_seen(const TileGrid& tiles, const glm::dquat& sphere_from_view, const ViewExtent& extent,
                           std::set<int>& seen) {
    const double widest_step_rad = std::min(pi / tiles.columns, 0.5 * pi / tiles.rows);
    const EquirectCamera sphere{tiles.columns, tiles.rows, {}};  // a pixel is a tile
    // Tangents of the rays are sinh of evenly spaced numbers, so adjacent rays differ in angle by at most that spacing.
    const double across = std::asinh(extent.half_width), down = std::asinh(extent.half_height);
    const auto steps = [&](double half) { return std::max(32, int(std::ceil(2 * half / widest_step_rad))); };
    const auto tangent = [](int step, int of, double half) { return std::sinh((2.0 * step / of - 1) * half); };
    const int columns = steps(across), rows = steps(down);
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const double x = tangent(i, columns, across), y = tangent(j, rows, down);
            const glm::dvec2 pixel = sphere.pixel(glm::normalize(sphere_from_view * glm::dvec3(x, y, -1)));
            const int column = std::clamp(int(pixel.x), 0, tiles.columns - 1);
            seen.insert(std::clamp(int(pixel.y), 0, tiles.rows - 1) * tiles.columns + column);
        }
    for (const bool is_top : {true, false}) {
        const glm::dvec3 pole = glm::conjugate(sphere_from_view) * glm::dvec3(0, is_top ? 1 : -1, 0);
        if (std::abs(pole.x) <= -pole.z * extent.half_width && std::abs(pole.y) <= -pole.z * extent.half_height)
            for (int column = 0; column < tiles.columns; ++column)
                seen.insert((is_top ? 0 : tiles.rows - 1) * tiles.columns + column);
    }
}

/// Focal length, in pixels, of the views that a base's depth is coded for. The base has larger pixels than its window,
/// so its depth may be coarser by the same factor.
inline double base_focal_length_px(const Camera& base, const Camera& window) {
    return default_focal_length_px * std::min(1.0, pixel_angle_rad(window) / pixel_angle_rad(base));
}

/// The pixels of a base, a full sphere with fewer pixels, that a window covers entirely, and their colours by the
/// window.
class WindowCover {
public:
    WindowCover(const WindowGrid& grid, WindowPlace place, int base_width, int base_height)
        : columns_(grid.columns, base_width, place.x, grid.width), rows_(grid.rows, base_height, place.y, grid.height) {
    }

    /// Whether the window covers all pixels of a rectangle of the base, which does not cross the base's seam.
    bool covers(int x, int y, int width = 1, int height = 1) const {
        const std::int64_t from_first = x - columns_.first;
        const std::int64_t column = (from_first % columns_.base + columns_.base) % columns_.base;
        return column + width <= columns_.count && y >= rows_.first && y + height <= rows_.first + rows_.count;
    }

    /// Sets each covered pixel of `base` to the mean of the window's pixels, weighted by their overlap (box filter).
    /// Both have the same channels.
    void put(ImageView<const float> window, ImageView<float> base) const {
        std::vector<double> sum(static_cast<std::size_t>(base.channels));
        for (std::int64_t j = rows_.first; j < rows_.first + rows_.count; ++j)
            for (std::int64_t i = columns_.first; i < columns_.first + columns_.count; ++i) {
                std::ranges::fill(sum, 0.0);
                rows_.each_below(j, [&](int y, double of_row) {
                    columns_.each_below(i, [&](int x, double of_column) {
                        for (std::size_t c = 0; c < sum.size(); ++c)
                            sum[c] += of_row * of_column * double(window.pixel(x, y)[c]);
                    });
                });
                std::ranges::transform(sum, base.pixel(static_cast<int>(i % columns_.base), static_cast<int>(j)),
                                       [](double mean) { return static_cast<float>(mean); });
            }
    }

private:
    /// Cover along one axis, in integers: the unit of length is 1 / (grid pixels x base pixels) of the axis.
    struct Axis {
        Axis(int grid_pixels, int base_pixels, int corner, int size)
            : grid(grid_pixels), base(base_pixels), begin(corner * base), first((begin + grid - 1) / grid),
              count(std::max<std::int64_t>((begin + size * base) / grid - first, 0)) {}

        /// Calls `use` with each pixel of the window that overlaps a covered pixel of the base, and its share of that
        /// pixel.
        template <typename Use>
        void each_below(std::int64_t pixel, const Use& use) const {
            const std::int64_t from = pixel * grid - begin, to = from + grid;
            for (std::int64_t i = from / base; i * base < to; ++i) {
                const std::int64_t within = std::min((i + 1) * base, to) - std::max(i * base, from);
                use(static_cast<int>(i), static_cast<double>(within) / static_cast<double>(grid));
            }
        }

        std::int64_t grid, base;
        std::int64_t begin;         ///< where the window begins
        std::int64_t first, count;  ///< covered pixels of the base; they may continue beyond the seam
    };

    Axis columns_, rows_;
};

}  // namespace equistream
