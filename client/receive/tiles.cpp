#include "decoded_pictures.h"

#include <client/warp/engine.h>
#include <equistream/error.h>
#include <equistream/image.h>
#include <equistream/text.h>
#include <equistream/window.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace equistream {

namespace {

struct Rectangle {
    int x = 0, y = 0, width = 0, height = 0;
};

const EquirectCamera& camera_of(const ReceivedPicture& tile) {
    return std::get<EquirectCamera>(tile.info.camera);
}

/// Where the tiles lie, and what part of the sphere holds all of them.
struct Mosaic {
    WindowGrid grid;                  ///< of all of them together
    WindowPlace place;                ///< the same
    std::vector<Rectangle> of_tiles;  ///< within it
    std::vector<Rectangle> holes;
};

/// Columns of tiles that hold all that are `used`, the sphere closed: the first of them and how many.
std::pair<int, int> narrowest(const std::vector<bool>& used) {
    const int count = int(used.size());
    std::pair<int, int> best{0, count};
    for (int first = 0; first < count; ++first) {
        int across = count;
        while (across > 0 && !used[std::size_t((first + across - 1) % count)])
            --across;
        if (used[std::size_t(first)] && across < best.second)
            best = {first, across};
    }
    return best;
}

Mosaic lay_out(const std::string& where, const std::vector<ReceivedPicture>& tiles) {
    const auto refuse = [&](const std::string& found) {
        return WorkError(expected_found(where, "tiles that are parts of one sphere", found));
    };
    const EquirectCamera& camera = camera_of(tiles.front());
    const std::optional<TilePart> first = tile_part(camera);
    if (!first)
        throw refuse("one of " + size_text(camera.width, camera.height) + " that fits no grid");
    const WindowGrid& one = first->windows;
    const TileGrid& counts = first->grid;
    std::vector<WindowPlace> places;
    std::vector<bool> used(std::size_t(counts.columns));
    std::vector<bool> there(std::size_t(counts.count()));
    int top = one.rows, bottom = 0;
    for (const ReceivedPicture& tile : tiles) {
        const std::optional<TilePart> part = tile_part(camera_of(tile));
        if (!part || !part->is_of_same_sphere(*first) || tile.width() != one.width || tile.height() != one.height)
            throw refuse("one of another size or place");
        places.push_back(part->place);
        used[std::size_t(part->number() % counts.columns)] = true;
        there[std::size_t(part->number())] = true;
        top = std::min(top, part->place.y);
        bottom = std::max(bottom, part->place.y + one.height);
    }
    const auto [left, across] = narrowest(used);
    if (std::int64_t{across} * one.width * (bottom - top) > max_image_pixels)  // tiles far apart, and all between them
        throw WorkError(expected_found(where, "tiles within " + std::to_string(max_image_pixels) + " pixels",
                                       size_text(across * one.width, bottom - top)));
    Mosaic mosaic{{one.columns, one.rows, across * one.width, bottom - top}, {left * one.width, top}, {}, {}};
    const auto within = [&](WindowPlace place) {
        return Rectangle{(place.x - mosaic.place.x + one.columns) % one.columns, place.y - top, one.width, one.height};
    };
    for (const WindowPlace& place : places)
        mosaic.of_tiles.push_back(within(place));
    for (int row = top / one.height; row < bottom / one.height; ++row)
        for (int i = 0; i < across; ++i)
            if (const int column = (left + i) % counts.columns; !there[std::size_t(row * counts.columns + column)])
                mosaic.holes.push_back(within({column * one.width, row * one.height}));
    return mosaic;
}

/// Puts planes of one kind together; `shrunk`: how many times fewer columns and rows they have than the picture.
class Plane {
public:
    Plane(const Mosaic& mosaic, int shrunk) : mosaic_(mosaic), shrunk_(shrunk) {}

    template <typename T>
    void put(ImageView<const T> tile, std::size_t number, ImageView<T> all) const {
        const Rectangle at = mosaic_.of_tiles[number];
        for (int y = 0; y < tile.height; ++y)
            std::memcpy(all.pixel(at.x / shrunk_, at.y / shrunk_ + y), tile.row(y),
                        sizeof(T) * std::size_t(tile.width) * std::size_t(tile.channels));
    }

    /// What no tile covers shows the base's nearest pixels.
    template <typename T>
    void fill_holes(ImageView<const T> base, ImageView<T> all) const {
        const int columns = mosaic_.grid.columns / shrunk_, rows = mosaic_.grid.rows / shrunk_;
        for (const Rectangle& hole : mosaic_.holes)
            for (int y = hole.y / shrunk_; y < (hole.y + hole.height) / shrunk_; ++y) {
                const T* from = base.row(nearest(y + mosaic_.place.y / shrunk_, rows, base.height));
                for (int x = hole.x / shrunk_; x < (hole.x + hole.width) / shrunk_; ++x) {
                    const int column = nearest((x + mosaic_.place.x / shrunk_) % columns, columns, base.width);
                    std::copy_n(from + std::ptrdiff_t(column) * base.channels, base.channels, all.pixel(x, y));
                }
            }
    }

private:
    /// Of `coarse` pixels in place of `fine` ones, the one that this pixel's middle lies in.
    static int nearest(int pixel, int fine, int coarse) {
        return int((2 * std::int64_t(pixel) + 1) * coarse / (2 * std::int64_t(fine)));
    }

    const Mosaic& mosaic_;
    int shrunk_;
};

template <typename T>
Yuv420Picture<const T> joined(const Mosaic& mosaic, const std::vector<ReceivedPicture>& tiles,
                              const Yuv420View<const T>& base, PictureMemory* memory,
                              Yuv420Picture<const T> ReceivedPicture::*planes) {
    const std::ptrdiff_t width = mosaic.grid.width, height = mosaic.grid.height;
    const auto bytes = sizeof(T) * std::size_t(width * height) * 3 / 2;
    std::shared_ptr<std::uint8_t> owner = memory != nullptr ? memory->take(bytes) : nullptr;
    if (owner == nullptr)
        owner = std::shared_ptr<std::uint8_t>(new std::uint8_t[bytes], std::default_delete<std::uint8_t[]>());
    T* const samples = reinterpret_cast<T*>(owner.get());
    const Yuv420View<T> all{{samples, int(width), int(height), 1, width},
                            {samples + width * height, int(width / 2), int(height / 2), 1, width / 2},
                            {samples + width * height * 5 / 4, int(width / 2), int(height / 2), 1, width / 2}};
    const Plane luma(mosaic, 1), chroma(mosaic, 2);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const Yuv420View<const T>& tile = (tiles[i].*planes).planes;
        luma.put(tile.y, i, all.y);
        chroma.put(tile.cb, i, all.cb);
        chroma.put(tile.cr, i, all.cr);
    }
    luma.fill_holes(base.y, all.y);
    chroma.fill_holes(base.cb, all.cb);
    chroma.fill_holes(base.cr, all.cr);
    return {{all.y, all.cb, all.cr}, owner};
}

/// Nothing unless all of them have it.
template <typename T>
Image<T> joined(const Mosaic& mosaic, const std::vector<ReceivedPicture>& tiles, const ReceivedPicture& base,
                Image<T> ReceivedPicture::*image) {
    const auto lacks = [&](const ReceivedPicture& picture) { return (picture.*image).empty(); };
    if (std::ranges::any_of(tiles, lacks) || (!mosaic.holes.empty() && lacks(base)))
        return {};
    Image<T> all(mosaic.grid.width, mosaic.grid.height, (tiles.front().*image).channels());
    const Plane plane(mosaic, 1);
    for (std::size_t i = 0; i < tiles.size(); ++i)
        plane.put(std::as_const(tiles[i].*image).view(), i, all.view());
    plane.fill_holes(std::as_const(base.*image).view(), all.view());
    return all;
}

}  // namespace

ReceivedPicture join_tiles(const std::string& where, std::vector<ReceivedPicture> tiles, const ReceivedPicture& base,
                           PictureMemory* memory) {
    const auto kind = [](const ReceivedPicture& picture) { return std::pair(picture.yuv.empty(), picture.pq.empty()); };
    for (const ReceivedPicture& tile : tiles) {
        if (!std::holds_alternative<EquirectCamera>(tile.info.camera) || kind(tile) != kind(base) ||
            !same_pose(tile.info.camera_pose, tiles.front().info.camera_pose))
            throw WorkError(expected_found(where, "tiles of one sphere and one format", "others"));
    }
    const Mosaic mosaic = lay_out(where, tiles);
    ReceivedPicture all;
    all.info = tiles.front().info;
    all.info.camera = window_camera(mosaic.grid, mosaic.place);
    all.decoder = tiles.front().decoder;
    for (const ReceivedPicture& tile : tiles) {
        all.decode_ms += tile.decode_ms;
        all.convert_ms += tile.convert_ms;
    }
    if (!base.yuv.empty())
        all.yuv = joined<std::uint8_t>(mosaic, tiles, base.yuv.planes, memory, &ReceivedPicture::yuv);
    else if (!base.pq.empty())
        all.pq = joined<std::uint16_t>(mosaic, tiles, base.pq.planes, memory, &ReceivedPicture::pq);
    else
        all.rgb = joined(mosaic, tiles, base, &ReceivedPicture::rgb);
    all.depth_m = joined(mosaic, tiles, base, &ReceivedPicture::depth_m);
    all.specular = joined(mosaic, tiles, base, &ReceivedPicture::specular);
    all.virtual_depth_m = joined(mosaic, tiles, base, &ReceivedPicture::virtual_depth_m);
    if (all.depth_m.empty())
        all.info.depth_code = std::nullopt;
    return all;
}

}  // namespace equistream
