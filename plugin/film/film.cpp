#include "film.h"

#include <equistream/cryptomatte.h>
#include <equistream/rec709.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

namespace equistream {
namespace {

constexpr const char* guide_names[] = {"guide_albedo", "guide_normal"};

bool is_guide(const std::string& name) {
    return std::find(std::begin(guide_names), std::end(guide_names), name) != std::end(guide_names);
}

/// Planes that are made of what colour samples met, and which of the two numbers of es_tile_put_ids.
constexpr std::pair<const char*, int> crypto_planes[] = {{"crypto_object", 0}, {"crypto_material", 1}};

bool is_crypto(const std::string& name) {
    return find_aov(name)->group == "cryptomatte";
}

/// While samples come in, a pixel of such a plane holds pairs: an id's bits, and how many samples met it.
void count_id(std::uint32_t id, float* pairs) {
    for (int rank = 0; rank < cryptomatte_ranks; ++rank, pairs += 2) {
        if (pairs[1] == 0)
            pairs[0] = std::bit_cast<float>(id);
        if (std::bit_cast<std::uint32_t>(pairs[0]) != id)
            continue;
        ++pairs[1];
        return;
    }
}

/// For each id the first one of the same name: Cryptomatte knows names alone.
std::vector<std::uint32_t> firsts_of_names(const std::vector<float>& names) {
    std::unordered_map<std::uint32_t, std::uint32_t> first;
    std::vector<std::uint32_t> firsts;
    for (const float name : names)
        firsts.push_back(
            first.try_emplace(std::bit_cast<std::uint32_t>(name), static_cast<std::uint32_t>(firsts.size()) + 1)
                .first->second);
    return firsts;
}

bool is_finite(const float* values, int count) {
    return std::all_of(values, values + count, [](float v) { return std::isfinite(v); });
}

glm::dvec3 vector3(const float* v) {
    return {v[0], v[1], v[2]};
}

/// Of a point seen at `pixel`, or of something infinitely far away there where `position_there_m` is none.
void store_motion(const Motion& motion, glm::dvec2 pixel, const float* position_there_m, float* to) {
    const bool near = position_there_m != nullptr && is_finite(position_there_m, 3);
    const glm::dvec2 moved = near ? motion.of_point(pixel, vector3(position_there_m)) : motion.of_direction(pixel);
    to[0] = static_cast<float>(moved.x);
    to[1] = static_cast<float>(moved.y);
}

/// One size of the picture: colour, and where there is some.
struct Level {
    FloatImage rgb;
    ByteImage known;
};

/// Half as wide and high, rounded up: the mean of what is known of each block.
Level halved(const Level& fine) {
    const int width = fine.rgb.width(), height = fine.rgb.height();
    Level coarse{FloatImage((width + 1) / 2, (height + 1) / 2, 3), ByteImage((width + 1) / 2, (height + 1) / 2, 1)};
    for (int y = 0; y < coarse.rgb.height(); ++y)
        for (int x = 0; x < coarse.rgb.width(); ++x) {
            float* const mean = coarse.rgb.pixel(x, y);
            int count = 0;
            for (int from_y = 2 * y; from_y < std::min(2 * y + 2, height); ++from_y)
                for (int from_x = 2 * x; from_x < std::min(2 * x + 2, width); ++from_x) {
                    if (*fine.known.pixel(from_x, from_y) == 0)
                        continue;
                    ++count;
                    for (int c = 0; c < 3; ++c)
                        mean[c] += fine.rgb.pixel(from_x, from_y)[c];
                }
            for (int c = 0; c < 3 && count > 0; ++c)
                mean[c] /= static_cast<float>(count);
            *coarse.known.pixel(x, y) = count > 0;
        }
    return coarse;
}

/// Of the coarser level, all of it known, at pixel i of the finer one: between the two nearest of its pixels.
struct Blend {
    int near, far;

    Blend(int i, int coarse_size, bool closes) : near(i / 2), far(near + (i % 2 == 0 ? -1 : 1)) {
        far = closes ? (far + coarse_size) % coarse_size : std::clamp(far, 0, coarse_size - 1);
    }
};

void fill_from(const Level& coarse, Level& fine, bool closes) {
    for (int y = 0; y < fine.rgb.height(); ++y) {
        const Blend rows(y, coarse.rgb.height(), false);
        for (int x = 0; x < fine.rgb.width(); ++x) {
            if (*fine.known.pixel(x, y) != 0)
                continue;
            const Blend columns(x, coarse.rgb.width(), closes);
            const float *a = coarse.rgb.pixel(columns.near, rows.near), *b = coarse.rgb.pixel(columns.far, rows.near);
            const float *c = coarse.rgb.pixel(columns.near, rows.far), *d = coarse.rgb.pixel(columns.far, rows.far);
            for (int k = 0; k < 3; ++k)
                fine.rgb.pixel(x, y)[k] = 0.5625f * a[k] + 0.1875f * (b[k] + c[k]) + 0.0625f * d[k];
        }
    }
}

}  // namespace

Film::Film(const FrameInfo& info, const FramePoses& poses, FilmSettings settings)
    : closes_(columns_close(info.camera) && !info.patches), width_(picture_width(info)), height_(picture_height(info)),
      tile_side_(settings.tile_side), tiles_across_(static_cast<std::uint32_t>((width_ + tile_side_ - 1) / tile_side_)),
      tile_count_(tiles_across_ * static_cast<std::uint32_t>((height_ + tile_side_ - 1) / tile_side_)),
      part_(settings.part), share_(settings.part), samples_per_pixel_(settings.samples_per_pixel),
      tile_samples_(std::move(settings.tile_samples)), takes_variance_(settings.variance),
      takes_guides_(settings.guides), backward_(info.camera, poses.here, poses.previous),
      forward_(info.camera, poses.here, poses.next), plane_names_(std::move(settings.planes)),
      has_holes_(settings.has_holes), references_(std::move(settings.references)),
      object_ids_(std::move(settings.object_ids)),
      material_ids_(std::move(settings.material_ids)), firsts_of_names_{firsts_of_names(object_ids_),
                                                                        firsts_of_names(material_ids_)} {}

/// Memory for tiles is taken when a host first asks for one: those that hand over whole planes need none.
void Film::start_film() {
    progress_.resize(all_tiles());
    reference_sums_.resize(references_.corners.size() * reference_halves * ReferenceTiles::pixels * reference_channels);
    next_tile_ = share_.first;
    if (part_.is_put_together())
        next_tile_ = all_tiles();
    if (is_whole()) {
        next_tile_ = first_tile_ = tile_count_;
        return;
    }
    radiance_sum_ = FloatImage(width_, height_, 4);
    left_out_ = IdImage(width_, height_, 1);
    if (takes_variance_)
        square_sum_ = Image<double>(width_, height_, 1);
    if (takes_guides_)
        guide_sum_ = FloatImage(width_, height_, 6);
    if (has_holes_)
        answered_ = ByteImage(width_, height_, 1);
    for (const std::string& name : plane_names_) {
        const AovInfo aov = *find_aov(name);
        const int channels = static_cast<int>(aov.channels.size());
        if (name == "colour" || is_guide(name) || whole_.contains(name))
            continue;
        if (aov.type == SampleType::id)
            ids_[name] = IdImage(width_, height_, channels);
        else
            real_[name] = FloatImage(width_, height_, channels);
    }
}

/// Whether tiles are asked for references alone: all else was handed over, the guides of a denoiser too.
bool Film::is_whole() const {
    const auto given = [this](const std::string& name) { return whole_.contains(name); };
    return std::ranges::all_of(plane_names_, given) && (!takes_guides_ || std::ranges::all_of(guide_names, given));
}

es_tile Film::tile(std::uint32_t id) const {
    es_tile tile{};
    tile.id = id;
    tile.sample_count = passes_of(id);
    if (is_reference(id)) {
        const glm::ivec2 corner = references_.corners[id - tile_count_];
        tile.x = corner.x;
        tile.y = corner.y;
        tile.width = std::min(ReferenceTiles::side, width_ - corner.x);
        tile.height = std::min(ReferenceTiles::side, height_ - corner.y);
        tile.pixel_count = static_cast<std::uint32_t>(tile.width * tile.height);
        return tile;
    }
    tile.x = static_cast<int>(id % tiles_across_) * tile_side_;
    tile.y = static_cast<int>(id / tiles_across_) * tile_side_;
    tile.width = std::min(tile_side_, width_ - tile.x);
    tile.height = std::min(tile_side_, height_ - tile.y);
    tile.pixel_count = static_cast<std::uint32_t>(tile.width * tile.height);
    return tile;
}

std::optional<es_tile> Film::next_tile() {
    if (is_whole() && references_.corners.empty())
        return std::nullopt;
    start_once();
    // The counter stops at the end, so that asking on and on cannot make it wrap.
    std::uint32_t id = next_tile_.load();
    while (id < all_tiles() && !next_tile_.compare_exchange_weak(id, id + share_.step)) {
    }
    if (id >= all_tiles())
        return std::nullopt;
    return tile(id);
}

bool Film::knows(const es_tile& given) const {
    if (given.id >= next_tile_.load() || given.id < first_tile_ || given.id % share_.step != share_.first)
        return false;
    const es_tile ours = tile(given.id);
    return given.x == ours.x && given.y == ours.y && given.width == ours.width && given.height == ours.height &&
           given.pixel_count == ours.pixel_count;
}

/// First sample of a plane that tiles fill, or null if it is not wanted or was handed over whole.
float* Film::real_target(const std::string& name) {
    const auto found = real_.find(name);
    return found == real_.end() || whole_.contains(name) ? nullptr : found->second.samples().data();
}

std::uint32_t* Film::id_target(const std::string& name) {
    const auto found = ids_.find(name);
    return found == ids_.end() || whole_.contains(name) ? nullptr : found->second.samples().data();
}

/// Where pixels may be holes, those that a host answers for are none.
void Film::mark_answered(const TilePixels& pixels) {
    if (!has_holes_)
        return;
    for (std::uint32_t i = 0; i < pixels.count(); ++i) {
        const glm::ivec2 at = pixels.at(i);
        *answered_.pixel(at.x, at.y) = 1;
    }
}

void Film::put_surfaces(const TilePixels& pixels, const es_surface* surfaces) {
    if (is_reference(pixels.tile.id))
        return;
    mark_answered(pixels);
    static constexpr es_surface miss{INFINITY, {}, {}, {}, {}, 0, 0, 0, 0, 0, {}, {}};
    // Calls `put(surface, pixel's centre, samples)` for each pixel, unless nobody wants the plane of tiles.
    const auto fill = [&](auto* plane, int channels, const auto& put) {
        for (std::uint32_t i = 0; i < pixels.count() && plane != nullptr; ++i) {
            const glm::ivec2 at = pixels.at(i);
            const bool hit = surfaces[i].distance_m >= 0 && std::isfinite(surfaces[i].distance_m);
            put(hit ? surfaces[i] : miss, glm::dvec2(at) + 0.5,
                plane + (static_cast<std::ptrdiff_t>(at.y) * width_ + at.x) * channels);
        }
    };
    using Vector = float(es_surface::*)[3];
    const auto fill_vector = [&](const char* name, Vector vector) {
        fill(real_target(name), 3, [=](const es_surface& s, glm::dvec2, float* to) {
            std::copy_n(is_finite(s.*vector, 3) ? s.*vector : miss.*vector, 3, to);
        });
    };
    const auto fill_motion = [&](const std::string& name, const Motion& motion, Vector surface_m, Vector image_m) {
        const auto store = [&](glm::dvec2 pixel, float distance_m, const float* point_m, float* to) {
            store_motion(motion, pixel, std::isfinite(distance_m) ? point_m : nullptr, to);
        };
        fill(real_target(name), 2,
             [&](const es_surface& s, glm::dvec2 pixel, float* to) { store(pixel, s.distance_m, s.*surface_m, to); });
        fill(real_target("virtual_" + name), 2, [&](const es_surface& s, glm::dvec2 pixel, float* to) {
            const bool shows_other = s.virtual_distance_m > 0;
            store(pixel, shows_other ? s.virtual_distance_m : s.distance_m, s.*(shows_other ? image_m : surface_m), to);
        });
    };
    const auto fill_id = [&](const char* name, std::uint32_t es_surface::*id) {
        fill(id_target(name), 1, [=](const es_surface& s, glm::dvec2, std::uint32_t* to) { *to = s.*id; });
    };
    fill(real_target("depth"), 1, [](const es_surface& s, glm::dvec2, float* to) { *to = s.distance_m; });
    fill(real_target("virtual_depth"), 1, [](const es_surface& s, glm::dvec2, float* to) {
        *to = s.virtual_distance_m > 0 ? s.virtual_distance_m : s.distance_m;
    });
    fill(real_target("specular"), 1,
         [](const es_surface& s, glm::dvec2, float* to) { *to = std::isfinite(s.specular) ? s.specular : 0; });
    fill_motion("backward", backward_, &es_surface::position_previous_m, &es_surface::virtual_previous_m);
    fill_motion("forward", forward_, &es_surface::position_next_m, &es_surface::virtual_next_m);
    fill_vector("normal", &es_surface::normal);
    fill_vector("albedo", &es_surface::albedo);
    fill_id("object_id", &es_surface::object_id);
    fill_id("material_id", &es_surface::material_id);
    fill_id("instance_id", &es_surface::instance_id);
    progress_[pixels.tile.id].surfaces = true;
}

bool Film::add_radiance(const TilePixels& pixels, const float* rgba) {
    TileProgress& progress = progress_[pixels.tile.id];
    if (progress.colour_passes >= passes_of(pixels.tile.id))
        return false;
    const std::uint32_t pass = progress.colour_passes++;
    if (is_reference(pixels.tile.id)) {
        double* sum = reference_sum(pixels.tile, pass < references_.samples / reference_halves ? 0 : 1);
        for (std::uint32_t i = 0; i < pixels.count(); ++i, rgba += 4, sum += reference_channels)
            if (is_finite(rgba, 4)) {
                for (int c = 0; c < 3; ++c)
                    sum[c] += rgba[c];
                ++sum[3];
            }
        return true;
    }
    mark_answered(pixels);
    const auto add = [this](const float* sample, float* sum, int x, int y) {
        if (!is_finite(sample, 4)) {
            ++*left_out_.pixel(x, y);
            return;
        }
        for (int c = 0; c < 4; ++c)
            sum[c] += sample[c];
        if (takes_variance_) {
            const double level = luminance(vector3(sample));
            *square_sum_.pixel(x, y) += level * level;
        }
    };
    if (pixels.listed != nullptr) {
        for (std::uint32_t i = 0; i < pixels.count(); ++i, rgba += 4) {
            const glm::ivec2 at = pixels.at(i);
            add(rgba, radiance_sum_.pixel(at.x, at.y), at.x, at.y);
        }
        return true;
    }
    // By rows: to find each pixel by a division takes twice as long.
    const es_tile tile = pixels.tile;
    for (int y = tile.y; y < tile.y + tile.height; ++y) {
        float* sum = radiance_sum_.pixel(tile.x, y);
        for (int x = tile.x; x < tile.x + tile.width; ++x, sum += 4, rgba += 4)
            add(rgba, sum, x, y);
    }
    return true;
}

bool Film::add_guides(const TilePixels& pixels, const float* guides) {
    if (is_reference(pixels.tile.id))
        return true;
    TileProgress& progress = progress_[pixels.tile.id];
    if (!takes_guides_ || progress.guide_passes >= passes_of(pixels.tile.id))
        return false;
    ++progress.guide_passes;
    for (std::uint32_t i = 0; i < pixels.count(); ++i, guides += 6) {
        const glm::ivec2 at = pixels.at(i);
        float* const sum = guide_sum_.pixel(at.x, at.y);
        for (int c = 0; c < 6; ++c)
            sum[c] += std::isfinite(guides[c]) ? guides[c] : 0;
    }
    return true;
}

bool Film::add_ids(const TilePixels& pixels, const std::uint32_t* ids) {
    if (is_reference(pixels.tile.id))
        return true;
    TileProgress& progress = progress_[pixels.tile.id];
    if (progress.id_passes >= passes_of(pixels.tile.id))
        return false;
    ++progress.id_passes;
    for (const auto& [name, which] : crypto_planes)
        if (float* const plane = real_target(name))
            for (std::uint32_t i = 0; i < pixels.count(); ++i) {
                const glm::ivec2 at = pixels.at(i);
                const std::vector<std::uint32_t>& firsts = firsts_of_names_[std::size_t(which)];
                if (const std::uint32_t id = ids[2 * i + std::uint32_t(which)]; id != 0)
                    count_id(id - 1 < firsts.size() ? firsts[id - 1] : id,
                             plane + (std::ptrdiff_t{at.y} * width_ + at.x) * 2 * cryptomatte_ranks);
            }
    return true;
}

/// Most covered first, by the names' hashes; of equal shares the lower id.
void Film::rank_ids(const char* name, const std::vector<float>& ids) {
    if (real_target(name) == nullptr)
        return;
    const std::string_view kind = name == std::string_view("crypto_object") ? "object " : "material ";
    FloatImage& plane = real_.at(name);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            float* const pairs = plane.pixel(x, y);
            std::array<std::pair<float, std::uint32_t>, cryptomatte_ranks> ranked;
            for (std::size_t rank = 0; rank < ranked.size(); ++rank)
                ranked[rank] = {-pairs[2 * rank + 1], std::bit_cast<std::uint32_t>(pairs[2 * rank])};
            std::ranges::sort(ranked);
            const float samples = static_cast<float>(std::max(passes_of(tile_at(x, y)), 1u));
            for (std::size_t rank = 0; rank < ranked.size(); ++rank) {
                const auto [count, id] = ranked[rank];
                pairs[2 * rank] = count == 0 ? 0
                                  : std::size_t{id} - 1 < ids.size()
                                      ? ids[id - 1]
                                      : cryptomatte_id(std::string(kind) + std::to_string(id));
                pairs[2 * rank + 1] = -count / samples;
            }
        }
}

bool Film::wants(const std::string& name) const {
    return (takes_guides_ && is_guide(name)) ||
           std::find(plane_names_.begin(), plane_names_.end(), name) != plane_names_.end();
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
    std::size_t with_colour = 0, with_surfaces = 0;  // tiles that are to have them
    std::size_t without_colour = 0, without_surfaces = 0, without_guides = 0, without_ids = 0;
    bool any_guides = false;
    for (std::uint32_t tile = share_.first; tile < all_tiles(); tile += share_.step) {
        const bool is_begun = tile < progress_.size();
        const TileProgress progress = is_begun ? progress_[tile] : TileProgress{};
        ++with_colour;
        without_colour += !is_begun || progress.colour_passes != passes_of(tile);
        if (is_reference(tile))
            continue;
        ++with_surfaces;
        without_surfaces += !progress.surfaces;
        without_guides += !is_begun || progress.guide_passes != passes_of(tile);
        without_ids += !is_begun || progress.id_passes != passes_of(tile);
        any_guides |= progress.guide_passes > 0;
    }
    std::vector<std::string> names = plane_names_;
    if (any_guides)  // of no use unless there are all
        names.insert(names.end(), std::begin(guide_names), std::end(guide_names));
    for (const std::string& name : names) {
        const std::size_t tiles = name == "colour"  ? without_colour
                                  : is_guide(name)  ? without_guides
                                  : is_crypto(name) ? without_ids
                                                    : without_surfaces;
        if (tiles > 0 && !whole_.contains(name))
            return "plane " + name + " unfinished in " + std::to_string(tiles) + " of " +
                   std::to_string(name == "colour" ? with_colour : with_surfaces) + " tiles";
    }
    return std::nullopt;
}

void Film::average_colour() {
    FloatImage colour(width_, height_, 4);
    FloatImage counts(takes_variance_ ? width_ : 0, height_, 1), variance(counts);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const std::uint32_t count = passes_of(tile_at(x, y)) - *left_out_.pixel(x, y);
            const float weight = count > 0 ? 1 / static_cast<float>(count) : 0.0f;
            const float* sum = radiance_sum_.pixel(x, y);
            for (int c = 0; c < 4; ++c)
                colour.pixel(x, y)[c] = sum[c] * weight;
            if (!takes_variance_)
                continue;
            *counts.pixel(x, y) = static_cast<float>(count);
            const double mean = luminance(vector3(sum)) * double(weight);
            const double squares = *square_sum_.pixel(x, y) - mean * mean * count;
            if (count > 1)
                *variance.pixel(x, y) = static_cast<float>(std::max(squares, 0.0) / (double(count) * (count - 1)));
        }
    real_["colour"] = std::move(colour);
    if (takes_variance_) {
        real_["samples"] = std::move(counts);
        real_["variance"] = std::move(variance);
    }
}

double* Film::reference_sum(const es_tile& tile, std::uint32_t half) {
    const std::size_t index = std::size_t{tile.id - tile_count_} * reference_halves + half;
    return &reference_sums_[index * ReferenceTiles::pixels * reference_channels];
}

void Film::average_references() {
    FloatImage reference(width_, height_, 4), repeat(width_, height_, 3);
    for (std::uint32_t id = tile_count_; id < progress_.size(); ++id) {
        if (progress_[id].colour_passes < references_.samples)
            continue;
        const es_tile of = tile(id);
        const double *first = reference_sum(of, 0), *second = reference_sum(of, 1);
        for (std::uint32_t i = 0; i < of.pixel_count; ++i, first += reference_channels, second += reference_channels) {
            const glm::ivec2 at = TilePixels{of}.at(i);
            if (first[3] == 0 || second[3] == 0)
                continue;
            for (int c = 0; c < 3; ++c) {
                reference.pixel(at.x, at.y)[c] = static_cast<float>(first[c] / first[3]);
                repeat.pixel(at.x, at.y)[c] = static_cast<float>(second[c] / second[3]);
            }
            reference.pixel(at.x, at.y)[3] = 1;
        }
    }
    real_["reference"] = std::move(reference);
    real_["reference_repeat"] = std::move(repeat);
}

void Film::finish_guides() {
    const bool given =
        std::any_of(progress_.begin(), progress_.end(), [](const TileProgress& t) { return t.guide_passes > 0; });
    for (int guide = 0; guide < 2 && given; ++guide) {
        if (whole_.contains(guide_names[guide]))
            continue;
        FloatImage mean(width_, height_, 4);
        ByteImage known(width_, height_, 1, 1);
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) {
                const std::uint32_t passes = passes_of(tile_at(x, y));
                *known.pixel(x, y) = passes > 0;
                for (int c = 0; c < 3 && passes > 0; ++c)
                    mean.pixel(x, y)[c] = guide_sum_.pixel(x, y)[3 * guide + c] / static_cast<float>(passes);
            }
        // Under a window nothing was traced. A denoiser that looks across its border must not see an edge there.
        if (std::ranges::find(known.samples(), 0) != known.samples().end())
            pad_colour(mean, known, closes_);
        FloatImage& out = real_[guide_names[guide]] = FloatImage(width_, height_, 3);
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                std::copy_n(mean.pixel(x, y), 3, out.pixel(x, y));
    }
}

std::int64_t Film::left_out_samples() const {
    const auto counts = left_out_.samples();
    return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

/// Of what tiles filled: a plane that was handed over whole says itself where nothing is.
void Film::leave_holes() {
    if (!whole_.contains("colour"))
        pad_colour(real_.at("colour"), answered_, closes_);
    const auto depth = real_.find("depth");
    if (depth == real_.end() || whole_.contains("depth"))
        return;
    const auto answered = answered_.samples();
    for (std::size_t pixel = 0; pixel < answered.size(); ++pixel)
        if (answered[pixel] == 0)
            depth->second.samples()[pixel] = std::numeric_limits<float>::quiet_NaN();
}

void Film::finish(Frame& frame) {
    if (!whole_.contains("colour"))
        average_colour();
    finish_guides();
    rank_ids("crypto_object", object_ids_);
    rank_ids("crypto_material", material_ids_);
    if (references_.samples > 0)
        average_references();
    if (has_holes_)
        leave_holes();
    frame.planes = std::move(real_);
    frame.ids = std::move(ids_);
}

void pad_colour(FloatImage& rgba, const ByteImage& known, bool closes) {
    std::vector<Level> levels{{FloatImage(rgba.width(), rgba.height(), 3), known}};
    for (int y = 0; y < rgba.height(); ++y)
        for (int x = 0; x < rgba.width(); ++x)
            std::copy(rgba.pixel(x, y), rgba.pixel(x, y) + 3, levels[0].rgb.pixel(x, y));
    while (levels.back().rgb.width() > 1 || levels.back().rgb.height() > 1)
        levels.push_back(halved(levels.back()));
    for (std::size_t level = levels.size() - 1; level-- > 0;)
        fill_from(levels[level + 1], levels[level], closes);
    for (int y = 0; y < rgba.height(); ++y)
        for (int x = 0; x < rgba.width(); ++x) {
            if (*known.pixel(x, y) != 0)
                continue;
            std::copy(levels[0].rgb.pixel(x, y), levels[0].rgb.pixel(x, y) + 3, rgba.pixel(x, y));
            rgba.pixel(x, y)[3] = 0;
        }
}

}  // namespace equistream
