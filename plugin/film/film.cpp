#include "film.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace equistream {
namespace {

/// 32 x 32 pixels: enough rays to be worth a call, few enough to keep every core busy to the end.
constexpr int tile_side = 32;

bool is_finite(const float* values, int count) {
    return std::all_of(values, values + count, [](float v) { return std::isfinite(v); });
}

void copy3(const float* from, float* to) {
    std::copy(from, from + 3, to);
}

glm::dvec3 vector3(const float* v) {
    return {v[0], v[1], v[2]};
}

void store(glm::dvec2 motion, float* to) {
    to[0] = static_cast<float>(motion.x);
    to[1] = static_cast<float>(motion.y);
}

}  // namespace

Film::Film(const Camera& camera, const FramePoses& poses, std::uint32_t samples_per_pixel,
           std::vector<std::string> planes)
    : camera_(camera), width_(width_of(camera)), height_(height_of(camera)),
      tiles_across_(static_cast<std::uint32_t>((width_ + tile_side - 1) / tile_side)),
      tile_count_(tiles_across_ * static_cast<std::uint32_t>((height_ + tile_side - 1) / tile_side)),
      samples_per_pixel_(samples_per_pixel), backward_(camera, poses.here, poses.previous),
      forward_(camera, poses.here, poses.next), plane_names_(std::move(planes)) {}

/// Memory for tiles is taken when a host first asks for one: those that hand over whole planes need none.
void Film::start_film() {
    progress_.resize(tile_count_);
    radiance_sum_ = FloatImage(width_, height_, 4);
    left_out_ = IdImage(width_, height_, 1);
    for (const std::string& name : plane_names_) {
        const AovInfo aov = *find_aov(name);
        const int channels = static_cast<int>(aov.channels.size());
        if (name == "colour" || whole_.contains(name))
            continue;
        if (aov.type == SampleType::id)
            ids_[name] = IdImage(width_, height_, channels);
        else
            real_[name] = FloatImage(width_, height_, channels);
    }
}

es_tile Film::tile(std::uint32_t id) const {
    es_tile tile{};
    tile.id = id;
    tile.x = static_cast<int>(id % tiles_across_) * tile_side;
    tile.y = static_cast<int>(id / tiles_across_) * tile_side;
    tile.width = std::min(tile_side, width_ - tile.x);
    tile.height = std::min(tile_side, height_ - tile.y);
    tile.pixel_count = static_cast<std::uint32_t>(tile.width * tile.height);
    tile.sample_count = samples_per_pixel_;
    return tile;
}

std::optional<es_tile> Film::next_tile() {
    std::call_once(film_started_, [this] { start_film(); });
    // The counter stops at the end, so that asking on and on cannot make it wrap.
    std::uint32_t id = next_tile_.load();
    while (id < tile_count_ && !next_tile_.compare_exchange_weak(id, id + 1)) {
    }
    if (id >= tile_count_)
        return std::nullopt;
    return tile(id);
}

bool Film::knows(const es_tile& given) const {
    if (given.id >= next_tile_.load())
        return false;
    const es_tile ours = tile(given.id);
    return given.x == ours.x && given.y == ours.y && given.width == ours.width && given.height == ours.height &&
           given.pixel_count == ours.pixel_count;
}

/// First sample of a plane that tiles fill, or null if it is not wanted or was handed over whole.
float* Film::real_target(const char* name) {
    const auto found = real_.find(name);
    return found == real_.end() || whole_.contains(name) ? nullptr : found->second.samples().data();
}

std::uint32_t* Film::id_target(const char* name) {
    const auto found = ids_.find(name);
    return found == ids_.end() || whole_.contains(name) ? nullptr : found->second.samples().data();
}

void Film::put_surfaces(const es_tile& tile, const es_surface* surfaces) {
    float* const depth = real_target("depth");
    float* const backward = real_target("backward");
    float* const forward = real_target("forward");
    float* const normal = real_target("normal");
    float* const albedo = real_target("albedo");
    float* const specular = real_target("specular");
    std::uint32_t* const object = id_target("object_id");
    std::uint32_t* const material = id_target("material_id");
    std::uint32_t* const instance = id_target("instance_id");
    const es_surface miss{INFINITY, {}, {}, {}, {}, 0, 0, 0, 0};
    for (std::uint32_t i = 0; i < tile.pixel_count; ++i) {
        const int x = tile.x + static_cast<int>(i) % tile.width;
        const int y = tile.y + static_cast<int>(i) / tile.width;
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y) * width_ + x;
        const bool hit = surfaces[i].distance_m >= 0 && std::isfinite(surfaces[i].distance_m);
        const es_surface& s = hit ? surfaces[i] : miss;
        const glm::dvec2 pixel(x + 0.5, y + 0.5);
        if (depth)
            depth[at] = s.distance_m;
        if (backward)
            store(hit && is_finite(s.position_previous_m, 3) ? backward_.of_point(pixel, vector3(s.position_previous_m))
                                                             : backward_.of_direction(pixel),
                  backward + 2 * at);
        if (forward)
            store(hit && is_finite(s.position_next_m, 3) ? forward_.of_point(pixel, vector3(s.position_next_m))
                                                         : forward_.of_direction(pixel),
                  forward + 2 * at);
        if (normal)
            copy3(is_finite(s.normal, 3) ? s.normal : miss.normal, normal + 3 * at);
        if (albedo)
            copy3(is_finite(s.albedo, 3) ? s.albedo : miss.albedo, albedo + 3 * at);
        if (object)
            object[at] = s.object_id;
        if (material)
            material[at] = s.material_id;
        if (instance)
            instance[at] = s.instance_id;
        if (specular)
            specular[at] = is_finite(&s.specular, 1) ? s.specular : 0;
    }
    progress_[tile.id].surfaces = true;
}

bool Film::add_radiance(const es_tile& tile, const float* rgba) {
    TileProgress& progress = progress_[tile.id];
    if (progress.colour_passes >= samples_per_pixel_)
        return false;
    ++progress.colour_passes;
    for (int y = tile.y; y < tile.y + tile.height; ++y) {
        float* sum = radiance_sum_.pixel(tile.x, y);
        for (int x = 0; x < tile.width; ++x, sum += 4, rgba += 4) {
            if (!is_finite(rgba, 4)) {
                ++*left_out_.pixel(tile.x + x, y);
                continue;
            }
            for (int c = 0; c < 4; ++c)
                sum[c] += rgba[c];
        }
    }
    return true;
}

bool Film::wants(const std::string& name) const {
    return std::find(plane_names_.begin(), plane_names_.end(), name) != plane_names_.end();
}

void Film::put_plane(const std::string& name, FloatImage image) {
    real_[name] = std::move(image);
    whole_.insert(name);
}

void Film::put_plane(const std::string& name, IdImage image) {
    ids_[name] = std::move(image);
    whole_.insert(name);
}

std::optional<std::string> Film::missing() const {
    std::size_t without_colour = tile_count_;
    std::size_t without_surfaces = tile_count_;
    for (const TileProgress& progress : progress_) {
        without_colour -= progress.colour_passes == samples_per_pixel_;
        without_surfaces -= progress.surfaces;
    }
    for (const std::string& name : plane_names_) {
        const std::size_t tiles = name == "colour" ? without_colour : without_surfaces;
        if (tiles > 0 && !whole_.contains(name))
            return "plane " + name + " unfinished in " + std::to_string(tiles) + " of " + std::to_string(tile_count_) +
                   " tiles";
    }
    return std::nullopt;
}

FloatImage Film::averaged_colour() const {
    FloatImage colour(width_, height_, 4);
    const auto sums = radiance_sum_.samples();
    const auto left_out = left_out_.samples();
    const auto means = colour.samples();
    for (std::size_t pixel = 0; pixel < left_out.size(); ++pixel) {
        const std::uint32_t count = samples_per_pixel_ - left_out[pixel];
        const float weight = count > 0 ? 1 / static_cast<float>(count) : 0.0f;
        for (std::size_t c = 0; c < 4; ++c)
            means[4 * pixel + c] = sums[4 * pixel + c] * weight;
    }
    return colour;
}

std::int64_t Film::left_out_samples() const {
    const auto counts = left_out_.samples();
    return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

void Film::finish(Frame& frame) {
    if (!whole_.contains("colour"))
        real_["colour"] = averaged_colour();
    frame.planes = std::move(real_);
    frame.ids = std::move(ids_);
}

}  // namespace equistream
