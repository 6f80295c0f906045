#include "depth_finder.h"
#include "eye_rays.h"
#include "source_lookup.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream {

namespace {

/// A ray of the eye by s = 1 / planar depth: the point at s lies in the direction ray + s eye, s / |ray + s eye| from
/// the source. 0 is infinity, larger is nearer.
struct Ray {
    Vec3f direction;  ///< planar depth 1
    Vec3f eye;
    float square = 0, along_eye = 0;  ///< direction . direction, direction . eye

    Vec3f at(float s) const { return direction + eye * s; }
    float inverse_distance(float s) const {
        const Vec3f d = at(s);
        return s / std::sqrt(dot(d, d));
    }
    /// Where the ray leaves the sphere of radius 1 / k around the source; the largest float if it never does.
    float leaves(float k, float eye_square) const {
        const float kk = k * k;
        const float a = 1 - kk * eye_square;
        const float b = kk * along_eye;
        const float root = std::sqrt(std::max(b * b + a * kk * square, 0.0f));
        return a > 0 ? (b + root) / a : std::numeric_limits<float>::max();
    }
};

struct Span {
    float far = 0, near = 0;  ///< of s
};

/// Where searches of one pixel begin.
struct Seeds {
    std::array<float, 3> s{};
    int count = 0;

    /// Unless it is none, or one that is there already.
    void add(float seed, const DepthAgreement& same) {
        const auto is_new = [&](float other) { return !same.same_inverse(other, seed); };
        if (seed >= 0 && std::all_of(s.begin(), s.begin() + count, is_new))
            s[std::size_t(count++)] = seed;
    }
};

/// The source's surface at any position of its picture: bilinear in 1/r where the four samples around it are joined,
/// else the nearest sample's own plane.
template <typename Lookup>
class Surface {
public:
    Surface(const SourceLattice& lattice, const Lookup& lookup, const DepthAgreement& same)
        : lattice_(lattice), lookup_(lookup), same_(same) {
        const auto half_square = [&](int x, int y, int dx, int dy) {
            const Vec3f chord = lattice.direction(x + dx, y + dy) + lattice.direction(x, y) * -1;
            return 0.5f * dot(chord, chord);
        };
        const int middle_x = lattice.width() / 2;
        for (int y = -1; y <= lattice.height(); ++y)
            across_.push_back(half_square(middle_x, std::clamp(y, 0, lattice.height() - 1), 1, 0));
        down_ = half_square(middle_x, lattice.height() / 2, 0, 1);
    }

    /// NaN outside the picture.
    float inverse_distance(Vec3f direction) const {
        const PixelPosition p = lookup_.project(direction);
        if (!lookup_.contains(p))
            return std::nanf("");
        const float fu = std::floor(p.u - 0.5f), fv = std::floor(p.v - 0.5f);
        const int x = int(fu), y = int(fv);
        const float a = p.u - 0.5f - fu, b = p.v - 0.5f - fv;
        const float k[4] = {lattice_.sample_inverse(x, y), lattice_.sample_inverse(x + 1, y),
                            lattice_.sample_inverse(x, y + 1), lattice_.sample_inverse(x + 1, y + 1)};
        const auto [low, high] = std::minmax({k[0], k[1], k[2], k[3]});
        const bool alike = same_.same_inverse(low, high) && k[0] + k[1] + k[2] + k[3] >= 0;
        if (alike || joined(x, y)) {
            // Between samples their directions' mean is shorter than 1, and what it is to be divided by.
            const float longer = 1 + a * (1 - a) * across_[std::size_t(y + 1)] + b * (1 - b) * down_;
            return ((k[0] * (1 - a) + k[1] * a) * (1 - b) + (k[2] * (1 - a) + k[3] * a) * b) * longer;
        }
        const int nearest_x = x + (a > 0.5f ? 1 : 0), nearest_y = y + (b > 0.5f ? 1 : 0);
        return std::max(continued(nearest_x, nearest_y, p.u - 0.5f - float(nearest_x), p.v - 0.5f - float(nearest_y)),
                        0.0f);
    }
    /// Of the sample nearest to the direction: quick, for signs only.
    float nearest_inverse_distance(Vec3f direction) const {
        const PixelPosition p = lookup_.project(direction);
        return lookup_.contains(p) ? lattice_.sample_inverse(int(std::floor(p.u)), int(std::floor(p.v)))
                                   : std::nanf("");
    }

private:
    bool connected(int x, int y, int dx, int dy) const {
        return same_.connected(lattice_.sample_inverse(x - dx, y - dy), lattice_.sample_inverse(x, y),
                               lattice_.sample_inverse(x + dx, y + dy),
                               lattice_.sample_inverse(x + 2 * dx, y + 2 * dy));
    }
    bool joined(int x, int y) const {
        return connected(x, y, 1, 0) && connected(x, y + 1, 1, 0) && connected(x, y, 0, 1) && connected(x + 1, y, 0, 1);
    }
    float slope(int x, int y, int dx, int dy, float towards) const {
        const bool before = connected(x - dx, y - dy, dx, dy), after = connected(x, y, dx, dy);
        const float here = lattice_.sample_inverse(x, y);
        if (towards > 0 ? after : !before && after)
            return lattice_.sample_inverse(x + dx, y + dy) - here;
        return before ? here - lattice_.sample_inverse(x - dx, y - dy) : 0;
    }
    float continued(int x, int y, float du, float dv) const {
        return lattice_.sample_inverse(x, y) + du * slope(x, y, 1, 0, du) + dv * slope(x, y, 0, 1, dv);
    }

    const SourceLattice& lattice_;
    const Lookup& lookup_;
    DepthAgreement same_;
    std::vector<float> across_;  ///< by row from -1 on: half the square of the chord between neighbours
    float down_ = 0;
};

/// The pixels of one tile of the eye.
template <typename Lookup>
class TileSearch {
public:
    TileSearch(const FindingTask& task, const EyeRays& rays, const Lookup& lookup)
        : rays_(rays), same_surface_(task.same_surface), found_{task.same_surface.box_radius_m, task.share},
          surface_(task.lattice, lookup, task.same_surface), eye_square_(dot(rays.eye(), rays.eye())),
          pixel_rad_(pixel_angle(task.source.camera)),
          max_arc_px_(4 * float(task.lattice.width() + task.lattice.height())) {}

    void search(PixelBox box, float nearest_inverse_m, float farthest_inverse_m, FloatImage& inverse_planar) const {
        for (int y = box.y0; y < box.y1; ++y) {
            float* row = inverse_planar.pixel(0, y);
            for (int x = box.x0; x < box.x1; ++x) {
                Ray ray{rays_.direction(x, y), rays_.eye()};
                ray.square = dot(ray.direction, ray.direction);
                ray.along_eye = dot(ray.direction, ray.eye);
                Span span{ray.leaves(farthest_inverse_m * (1 - beyond_samples), eye_square_),
                          std::min(ray.leaves(nearest_inverse_m * (1 + beyond_samples), eye_square_), nearest_s)};
                row[x] = solve(ray, span, seeds_around(box, inverse_planar, x, y, span.far));
            }
        }
    }

private:
    static float pixel_angle(const Camera& camera) {
        return float(std::visit([](const auto& c) { return c.pixel_angle_rad(); }, camera));
    }

    /// Where to begin: at what the neighbours found, each surface among them once, and from infinity or the farthest
    /// there is. On a silhouette both sides are among them.
    Seeds seeds_around(PixelBox box, const FloatImage& inverse_planar, int x, int y, float far) const {
        Seeds seeds;
        const auto add = [&](int neighbour_x, int neighbour_y) {
            if (neighbour_x >= box.x0 && neighbour_x < box.x1 && neighbour_y >= box.y0)
                seeds.add(inverse_planar.pixel(neighbour_x, neighbour_y)[0], same_surface_);
        };
        add(x - 1, y);
        add(x, y - 1);
        add(x + 1, y - 1);
        if (seeds.count == 0)
            seeds.add(far, same_surface_);
        return seeds;
    }

    /// Of the places where the seeds come to rest, the nearest to the eye, unless something lies before it.
    float solve(const Ray& ray, Span span, const Seeds& seeds) const {
        const float arc_px = arc(ray, span.far, span.near);
        float nearest = nothing_found;
        for (int i = 0; i < seeds.count; ++i)
            nearest = std::max(nearest, converge(ray, std::clamp(seeds.s[std::size_t(i)], span.far, span.near)));
        if (nearest < 0)
            return scan(ray, span, span.near, arc_px);
        const float before = arc_px <= 1 ? nearest : last_before_anything(ray, nearest, span.near);
        return before == nearest ? nearest : scan(ray, span, before, arc(ray, span.far, before));
    }

    /// Pixels of the source between two points of a ray, never fewer than lie in its picture: most of a long way round
    /// a narrow picture lies beside it.
    float arc(const Ray& ray, float s, float other) const {
        const Vec3f a = ray.at(s), b = ray.at(other);
        const Vec3f cross{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
        const float sine = std::sqrt(dot(cross, cross));
        return std::min(fast_atan2(sine, dot(a, b)) / pixel_rad_, max_arc_px_);
    }

    /// The fixed point of s -> where the ray leaves the sphere that the surface in the direction of s lies on, with
    /// Aitken's extrapolation, which is exact on planes after two steps; nothing_found if it does not come to rest.
    float converge(const Ray& ray, float s) const {
        float last = s, last_but_one = s;
        for (int i = 0; i < 6; ++i) {
            const float k = surface_.inverse_distance(ray.at(s));
            if (!(k >= 0))
                return nothing_found;
            const float next = ray.leaves(k, eye_square_);
            if (found_.same_inverse(ray.inverse_distance(s), k))
                return next;
            last_but_one = last;
            last = s;
            s = next;
            if (i % 3 == 1) {
                const float bend = s - 2 * last + last_but_one;
                const float extrapolated = last_but_one - (last - last_but_one) * (last - last_but_one) / bend;
                s = extrapolated >= 0 ? extrapolated : s;
            }
        }
        return nothing_found;
    }

    /// From the eye outwards to s by the nearest samples: the last place before anything of the source's; s if there is
    /// nothing.
    float last_before_anything(const Ray& ray, float s, float near) const {
        const int steps = int(arc(ray, s, near));
        float before = near;
        for (int i = steps; i >= 1; --i) {
            const float here = s + (near - s) * float(i) / float(steps + 1);
            const float k = surface_.nearest_inverse_distance(ray.at(here));
            if (k > ray.inverse_distance(here) && !same_surface_.same_inverse(k, ray.inverse_distance(here)))
                return before;
            before = here;
        }
        return s;
    }

    /// From `from`, before everything, outwards in steps of at most a pixel: the first place where the ray goes in
    /// through a surface.
    float scan(const Ray& ray, Span span, float from, float arc_px) const {
        const int steps = int(arc_px / 0.75f) + 2;
        float before = from * (1 + 1e-5f) + 1e-9f;
        bool in_front = true;
        for (int i = 0; i <= steps; ++i) {
            const float s = from + (span.far * (1 - 1e-5f) - from) * float(i) / float(steps);
            const bool now_in_front = !(surface_.inverse_distance(ray.at(s)) >= ray.inverse_distance(s));
            if (in_front && !now_in_front) {
                const float crossing = bisect(ray, before, s);
                if (crossing >= 0)
                    return crossing;
            }
            in_front = now_in_front;
            before = s;
        }
        return nothing_found;
    }

    /// In front at `near`, behind at `far`. A jump between two surfaces is no crossing.
    float bisect(const Ray& ray, float near, float far) const {
        for (int i = 0; i < 24; ++i) {
            const float s = 0.5f * (near + far);
            const float k = surface_.inverse_distance(ray.at(s));
            const float of_ray = ray.inverse_distance(s);
            if (k >= 0 && found_.same_inverse(of_ray, k))
                return ray.leaves(k, eye_square_);
            (k >= of_ray ? far : near) = s;
        }
        return nothing_found;
    }

    const EyeRays& rays_;
    DepthAgreement same_surface_, found_;
    Surface<Lookup> surface_;
    float eye_square_ = 0, pixel_rad_ = 1, max_arc_px_ = 0;
};

/// Halves boxes of the eye, and the list of what may be seen through them, down to tiles.
class Tiles {
public:
    struct Block {
        int x, y;
    };
    struct Tile {
        PixelBox box;
        float nearest_inverse_m, farthest_inverse_m;
    };

    explicit Tiles(const FindingTask& task) : task_(task) {
        std::vector<Block> all;
        for (int y = 0; y < task.lattice.block_rows(); ++y)
            for (int x = 0; x < task.lattice.block_columns(); ++x)
                all.push_back({x, y});
        divide({0, 0, task.eye.camera.width, task.eye.camera.height}, all);
    }
    const std::vector<Tile>& tiles() const { return tiles_; }

private:
    void divide(PixelBox box, const std::vector<Block>& candidates) {
        const SeenThrough seen(task_.eye.camera, task_.eye.pose, task_.source.pose, box);
        std::vector<Block> blocks;
        for (const Block& block : candidates)
            if (seen.may_show(task_.lattice.summary(block.x, block.y)))
                blocks.push_back(block);
        const int width = box.x1 - box.x0, height = box.y1 - box.y0;
        if (blocks.empty())
            return;
        if (width <= 32 && height <= 32) {
            Tile tile{box, 0, std::numeric_limits<float>::max()};
            for (const Block& block : blocks) {
                const SourceLattice::Summary& of = task_.lattice.summary(block.x, block.y);
                tile.nearest_inverse_m = std::max(tile.nearest_inverse_m, of.nearest_inverse_m);
                tile.farthest_inverse_m = std::min(tile.farthest_inverse_m, of.farthest_inverse_m);
            }
            tiles_.push_back(tile);
            return;
        }
        PixelBox first = box, second = box;
        if (width > height)
            first.x1 = second.x0 = box.x0 + width / 2;
        else
            first.y1 = second.y0 = box.y0 + height / 2;
        divide(first, blocks);
        divide(second, blocks);
    }

    const FindingTask& task_;
    std::vector<Tile> tiles_;
};

template <typename Lookup>
void find_with(const Lookup& lookup, const FindingTask& task, FloatImage& inverse_planar) {
    const EyeRays rays(task.eye.camera, task.eye.pose, task.source.pose);
    const Tiles tiles(task);
    const TileSearch<Lookup> search(task, rays, lookup);
    tbb::parallel_for(std::size_t{0}, tiles.tiles().size(), [&](std::size_t i) {
        const Tiles::Tile& tile = tiles.tiles()[i];
        search.search(tile.box, tile.nearest_inverse_m, tile.farthest_inverse_m, inverse_planar);
    });
}

class GatherFinder : public DepthFinder {
public:
    void find(const FindingTask& task, FloatImage& inverse_planar) const override {
        if (const auto* sphere = std::get_if<EquirectCamera>(&task.source.camera))
            find_with(EquirectLookup(*sphere), task, inverse_planar);
        else
            find_with(PerspectiveLookup(std::get<PerspectiveCamera>(task.source.camera)), task, inverse_planar);
    }
};

}  // namespace

std::unique_ptr<DepthFinder> make_gather_finder() {
    return std::make_unique<GatherFinder>();
}

}  // namespace equistream
