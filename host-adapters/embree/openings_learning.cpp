// The paths that SkyOpenings is learned from, and the balls that cover what they leave a building through.
#include "path_tracer.h"

#include <equistream/threads.h>
#include <scenes/embree/embree_rays.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>

namespace equistream::embree_host {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr std::size_t records_a_path = 4;
constexpr int max_surfaces = 32;  // of a path, panes included
/// Variance of skylight must shrink by this factor, or the scene is better off without.
constexpr double min_gain = 1.5;
/// On a ball's squared radius: what the first paths left through is less than all of an opening.
constexpr float margin = 1.5f;
/// Paths of each round, and the most balls added after it.
struct Round {
    std::size_t paths, openings;
};
constexpr Round rounds[] = {{1u << 14, 96}, {1u << 16, 64}, {1u << 17, 0}};

/// Calls what `make()` gives with each number below `count`, on threads of their own: tracing changes how a thread
/// rounds.
template <typename Make>
void for_each_index(std::size_t count, unsigned threads, const Make& make) {
    constexpr std::size_t piece = 64;
    std::atomic<std::size_t> next = 0;
    const auto helpers = start_threads(threads, [&] {
        trace_thread_init();
        const auto work = make();
        for (std::size_t begin = next.fetch_add(piece); begin < count; begin = next.fetch_add(piece))
            for (std::size_t k = begin; k < std::min(begin + piece, count); ++k)
                work(k);
    });
}

glm::vec3 unpacked(const PackedDirection& packed) {
    return glm::normalize(unpack_direction(packed));
}

/// Traces one path at a time. Everything scatters as if it were matte, but for panes, which light goes straight
/// through: a density needs no more.
class Explorer {
public:
    /// Guided by what is known so far.
    Explorer(const TracedScene& scene, const SkyOpenings& cells, std::span<const SkyOpening> openings)
        : scene_(scene), cells_(cells), textures_(scene.textures) {
        OpeningList::append(openings, numbers_);
        all_ = OpeningList(numbers_);
    }

    void explore(const glm::vec3& eye, Sampler numbers, std::span<SkyRecord> path) {
        glm::vec3 origin = eye, direction = sample_cone({numbers.next_hashed(), numbers.next_hashed()}, 2);
        float passed = 1;
        std::size_t count = 0;
        for (int surfaces = 0; surfaces < max_surfaces; ++surfaces) {
            RTCRayHit ray = embree_ray_hit(origin, direction);
            scene_.bvh.intersect1(ray);
            const HitId hit = scene_.bvh.resolve(ray.hit);
            if (hit.instance == no_index) {
                if (count > 0)
                    path[count - 1].light = passed * luminance(scene_.lights.sampled_sky(direction));
                return;
            }
            const ShadingPoint point = scene_.shading.surface_at(hit, origin, direction, ray.ray.tfar);
            const ShadingMaterial& material = scene_.shading.material(point.material);
            if (material.thin_glass) {
                const auto surface = surface_parameters(material, point, 0, glm::vec3(0.5f), textures_);
                passed *= luminance(straight_transmittance(surface, std::abs(glm::dot(point.normal, direction))));
                origin = offset_origin(point.position, -point.geometric_normal, point.reach);
                continue;
            }
            if (count == path.size())
                return;
            SkyRecord& record = path[count++];
            record.position = point.position;
            record.normal = pack_direction(point.normal);
            record.goes_on = true;
            direction = choose(point, numbers);
            const float cosine = glm::dot(direction, point.normal);
            if (!(cosine > 0) || glm::dot(direction, point.geometric_normal) <= 0)
                return;
            record.direction = pack_direction(direction);
            record.cosine = cosine;
            record.weight = cosine / pi_f / pdf(point, direction, cosine);
            origin = offset_origin(point.position, point.geometric_normal, point.reach);
            passed = 1;
        }
    }

private:
    /// By the cell, by all openings alike, or by the cosine.
    glm::vec3 choose(const ShadingPoint& point, Sampler& numbers) {
        list_ = cells_.empty() ? OpeningList() : cells_.at(point.position, point.normal).list;
        by_cell_ = list_.empty() ? 0 : 0.4f;
        by_all_ = all_.empty() ? 0 : cells_.empty() ? 0.5f : 0.2f;
        const float way = numbers.next_hashed();
        const glm::vec2 u{numbers.next_hashed(), numbers.next_hashed()};
        if (way < by_cell_)
            return list_.sample(point.position, u);
        if (way < by_cell_ + by_all_)
            return all_.sample(point.position, u);
        return glm::normalize(ShadingFrame(point.normal).to_world(sample_cosine_hemisphere(u)));
    }

    float pdf(const ShadingPoint& point, const glm::vec3& direction, float cosine) const {
        float sum = (1 - by_cell_ - by_all_) * cosine / pi_f;
        if (by_cell_ > 0)
            sum += by_cell_ * list_.pdf(point.position, direction);
        if (by_all_ > 0)
            sum += by_all_ * all_.pdf(point.position, direction);
        return sum;
    }

    const TracedScene& scene_;
    const SkyOpenings& cells_;
    Textures::Reader textures_;
    std::vector<float> numbers_;
    OpeningList all_;   // made of numbers_
    OpeningList list_;  // where the path is
    float by_cell_ = 0, by_all_ = 0;
};

/// Where a ray to the sky leaves the building: the first place from which a good part of all directions see the sky.
class Threshold {
public:
    explicit Threshold(const TracedScene& scene) : scene_(scene), textures_(scene.textures) {}

    /// False where the ray begins in the open, or never gets there.
    bool find(const glm::vec3& origin, const glm::vec3& direction, glm::vec3& at) {
        float inside = 0, outside = 0.02f;
        if (is_open(origin))
            return false;
        while (!is_open(origin + outside * direction)) {
            inside = outside;
            outside *= 2;
            if (outside > farthest_m)
                return false;
        }
        for (int step = 0; step < 4; ++step) {
            const float middle = 0.5f * (inside + outside);
            (is_open(origin + middle * direction) ? outside : inside) = middle;
        }
        at = origin + 0.5f * (inside + outside) * direction;
        return true;
    }

private:
    static constexpr float farthest_m = 1e4f;

    bool is_open(const glm::vec3& at) {
        constexpr int directions = 16;
        int seen = 0;
        for (int i = 0; i < directions; ++i) {
            const float turns = 0.618034f * static_cast<float>(i);
            const Segment segment{at, sample_cone({(static_cast<float>(i) + 0.5f) / directions, turns}, 2), infinity};
            seen += largest(transmittance(scene_.bvh, scene_.shading, textures_, segment)) > 0;
        }
        return seen >= directions / 4;
    }

    const TracedScene& scene_;
    Textures::Reader textures_;
};

struct Place {
    glm::vec3 at{0};
    float light = 0;  // 0: none
};

/// Balls around `places`, at most `most`. What spreads most light over most space is split first.
void cover(std::vector<Place> places, std::size_t most, std::vector<SkyOpening>& openings) {
    struct Group {
        std::size_t begin, end;
        glm::vec3 low{infinity}, high{-infinity};
        float light = 0;

        float spread() const { return end - begin < 4 ? 0 : light * glm::dot(high - low, high - low); }
    };
    const auto group = [&](std::size_t begin, std::size_t end) {
        Group g{begin, end};
        for (std::size_t i = begin; i < end; ++i) {
            g.low = glm::min(g.low, places[i].at);
            g.high = glm::max(g.high, places[i].at);
            g.light += places[i].light;
        }
        return g;
    };
    std::vector<Group> groups{group(0, places.size())};
    while (groups.size() < most) {
        const auto widest = std::ranges::max_element(groups, {}, &Group::spread);
        if (!(widest->spread() > 0))
            break;
        const Group g = *widest;
        const int axis = longest_axis(g.high - g.low);
        const float middle = 0.5f * (g.low[axis] + g.high[axis]);
        const auto begin = places.begin() + static_cast<std::ptrdiff_t>(g.begin);
        const auto end = places.begin() + static_cast<std::ptrdiff_t>(g.end);
        const auto cut = std::stable_partition(begin, end, [&](const Place& p) { return p.at[axis] < middle; });
        const auto at = static_cast<std::size_t>(cut - places.begin());
        if (at == g.begin || at == g.end)
            break;
        *widest = group(g.begin, at);
        groups.push_back(group(at, g.end));
    }
    for (const Group& g : groups) {
        const glm::vec3 half = 0.5f * (g.high - g.low);
        if (g.light > 0 && glm::dot(half, half) > 0)
            openings.push_back({g.low + half, margin * glm::dot(half, half), g.light});
    }
}

/// Adds balls for the skylight of `records` that `openings` do not cover. Their shares serve later paths alone.
void find_openings(const TracedScene& scene, std::span<const SkyRecord> records, unsigned threads, std::size_t most,
                   std::vector<SkyOpening>& openings) {
    std::vector<float> numbers;
    OpeningList::append(openings, numbers);
    const OpeningList known(numbers);
    std::vector<std::uint32_t> lit;
    for (std::uint32_t i = 0; i < records.size(); ++i)
        if (records[i].light > 0 &&
            (known.empty() || known.pdf(records[i].position, unpacked(records[i].direction)) == 0))
            lit.push_back(i);
    constexpr std::size_t max_places = 2048;
    const std::size_t step = lit.size() / max_places + 1;
    std::vector<Place> places(lit.size() / step);
    for_each_index(places.size(), threads, [&] {
        return [&, threshold = std::make_unique<Threshold>(scene)](std::size_t k) {
            const SkyRecord& r = records[lit[k * step]];
            const glm::vec3 from = offset_origin(r.position, unpacked(r.normal), 0);
            if (threshold->find(from, unpacked(r.direction), places[k].at))
                places[k].light = static_cast<float>(step) * r.weight * r.light;
        };
    });
    std::erase_if(places, [](const Place& p) { return !(p.light > 0); });
    float all_light = 0;
    for (const SkyRecord& r : records)
        all_light += r.weight * r.light;
    const std::size_t before = openings.size();
    if (places.size() > 1)
        cover(std::move(places), most, openings);
    for (std::size_t k = before; k < openings.size(); ++k)
        openings[k].share /= all_light;
    float total = 0;
    for (const SkyOpening& opening : openings)
        total += opening.share;
    for (SkyOpening& opening : openings)
        opening.share /= total;
}

}  // namespace

SkyOpenings learn_openings(const TracedScene& scene, std::span<const glm::vec3> eyes, unsigned threads) {
    const auto& image = scene.lights.sky_image;
    if (eyes.empty() || !scene.options.next_event || (is_black(scene.lights.sky) && (!image || image->is_black())))
        return {};
    std::vector<SkyRecord> records;
    std::vector<SkyOpening> openings;
    SkyOpenings table;
    for (const Round& round : rounds) {
        const std::size_t known = records.size();
        records.resize(known + round.paths * records_a_path);
        for_each_index(round.paths, threads, [&] {
            return [&, explorer = std::make_unique<Explorer>(scene, table, openings)](std::size_t k) {
                const std::size_t i = known / records_a_path + k;
                explorer->explore(eyes[i % eyes.size()], Sampler(0x736b79, static_cast<std::uint32_t>(i)),
                                  std::span(records).subspan(i * records_a_path, records_a_path));
            };
        });
        if (round.openings > 0)
            find_openings(scene, std::span(records).subspan(known), threads, round.openings, openings);
        if (openings.empty())
            return {};
        if (known == 0)
            continue;
        table = SkyOpenings(records, openings);
        if (table.gain() < min_gain)
            return {};
    }
    return table;
}

}  // namespace equistream::embree_host
