#include "hidden_layer.h"

#include <cmath>

namespace equistream {
namespace {

es_ray ray_of(const es_tile& tile, std::uint32_t pixel, const FrameRays& rays) {
    const auto width = static_cast<std::uint32_t>(tile.width);
    es_ray ray = rays.geometry(tile.x + static_cast<int>(pixel % width), tile.y + static_cast<int>(pixel / width));
    ray.pixel = pixel;
    return ray;
}

}  // namespace

HiddenLayer::Search& HiddenLayer::search_of(const es_tile& tile) {
    const std::lock_guard lock(mutex_);
    Search& search = searches_[tile.id];
    if (search.pixels.empty())
        search.pixels.resize(tile.pixel_count);
    return search;
}

const HiddenLayer::Found* HiddenLayer::found(const es_tile& tile) const {
    const std::lock_guard lock(mutex_);
    const auto known = found_.find(tile.id);
    return known == found_.end() ? nullptr : &known->second;
}

std::uint32_t HiddenLayer::ask(const es_tile& tile, const FrameRays& rays, es_ray* out) {
    if (found(tile) != nullptr)
        return 0;
    Search& search = search_of(tile);
    search.asked.clear();
    for (std::uint32_t pixel = 0; pixel < tile.pixel_count; ++pixel)
        if (!search.pixels[pixel].is_done()) {
            *out++ = search.pixels[pixel].question(ray_of(tile, pixel, rays), box_);
            search.asked.push_back(pixel);
        }
    const auto count = static_cast<std::uint32_t>(search.asked.size());
    if (count == 0)
        finish(tile, search);
    return count;
}

bool HiddenLayer::tell(const es_tile& tile, const FrameRays& rays, const float* distances_m) {
    if (found(tile) != nullptr)
        return false;
    Search& search = search_of(tile);
    if (search.asked.empty())
        return false;
    for (const std::uint32_t pixel : search.asked)
        search.pixels[pixel].answer(*distances_m++, ray_of(tile, pixel, rays), box_);
    search.asked.clear();
    return true;
}

void HiddenLayer::finish(const es_tile& tile, const Search& search) {
    Found found;
    for (std::uint32_t pixel = 0; pixel < tile.pixel_count; ++pixel)
        if (const float begin_m = search.pixels[pixel].begin_m(); !std::isnan(begin_m)) {
            found.pixels.push_back(pixel);
            found.begin_m.push_back(begin_m);
        }
    const std::lock_guard lock(mutex_);
    searches_.erase(tile.id);  // `search` is gone from here on
    found_[tile.id] = std::move(found);
}

}  // namespace equistream
