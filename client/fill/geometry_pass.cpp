#include "fill.h"

#include <equistream/rec709.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>

namespace equistream {

namespace {

// Where light is looked for that a gap's surface receives.

constexpr int tile_side = 8;
constexpr int sample_step = 2;          ///< of filled pixels, those at every second column and row are asked
constexpr int lit_tiles_around = 2;     ///< a tile with gaps: those whose samples are asked
constexpr int farthest_light_tile = 6;  ///< around a gap's own where its instance is looked for
constexpr std::size_t enough_light_samples = 12;
constexpr float min_base = 0.02f;  ///< darker surfaces' colours say little about their light
constexpr float min_light_weight = 1e-3f;

struct Pixel {
    int x = 0, y = 0;
};

/// A filled pixel: what it shows and what the geometry has there.
struct LitSample {
    Pixel pixel;
    GeometryHit hit;
    glm::vec3 seen{0};  ///< linear
};

class ToLinear {
public:
    ToLinear() {
        for (std::size_t i = 0; i < table_.size(); ++i)
            table_[i] = srgb_to_linear(float(i) / 255);
    }
    glm::vec3 operator()(const std::uint8_t* rgba) const { return {table_[rgba[0]], table_[rgba[1]], table_[rgba[2]]}; }

private:
    std::array<float, 256> table_{};
};

/// Filled pixels near gaps, by tiles.
class LitSamples {
public:
    LitSamples(const EyePicture& picture, const Gaps& gaps)
        : columns_((picture.origin.width() + tile_side - 1) / tile_side),
          rows_((picture.origin.height() + tile_side - 1) / tile_side), first_(std::size_t(columns_) * rows_ + 1) {
        std::vector<std::uint8_t> wanted(std::size_t(columns_) * rows_);
        constexpr int reach = lit_tiles_around;
        for (const GapSpan& span : gaps.spans())
            for (int row = std::max(span.y / tile_side - reach, 0);
                 row <= std::min(span.y / tile_side + reach, rows_ - 1); ++row)
                for (int column = std::max(span.begin / tile_side - reach, 0);
                     column <= std::min((span.end - 1) / tile_side + reach, columns_ - 1); ++column)
                    wanted[std::size_t(row) * columns_ + column] = 1;
        for (int row = 0; row < rows_; ++row)
            for (int column = 0; column < columns_; ++column) {
                const std::size_t tile = std::size_t(row) * columns_ + column;
                first_[tile] = samples_.size();
                if (wanted[tile] != 0)
                    add_tile(picture, column, row);
            }
        first_.back() = samples_.size();
    }

    std::span<LitSample> all() { return samples_; }

    /// Of one instance, from the tile of a pixel outwards, until there are enough.
    std::vector<const LitSample*> around(Pixel pixel, std::uint32_t instance) const {
        std::vector<const LitSample*> found;
        const int column = pixel.x / tile_side, row = pixel.y / tile_side;
        for (int ring = 0; ring <= farthest_light_tile && found.size() < enough_light_samples; ++ring)
            for (int y = std::max(row - ring, 0); y <= std::min(row + ring, rows_ - 1); ++y) {
                const bool edge = std::abs(y - row) == ring;
                for (int x = column - ring; x <= column + ring; x += edge || ring == 0 ? 1 : 2 * ring)
                    if (x >= 0 && x < columns_)
                        add_of(instance, std::size_t(y) * columns_ + x, found);
            }
        return found;
    }

private:
    void add_tile(const EyePicture& picture, int column, int row) {
        for (int y = row * tile_side; y < std::min((row + 1) * tile_side, picture.origin.height()); y += sample_step)
            for (int x = column * tile_side; x < std::min((column + 1) * tile_side, picture.origin.width());
                 x += sample_step)
                if (*picture.origin.pixel(x, y) != std::uint8_t(PixelOrigin::gap))
                    samples_.push_back({{x, y}, {}, to_linear_(picture.rgba.pixel(x, y))});
    }
    void add_of(std::uint32_t instance, std::size_t tile, std::vector<const LitSample*>& found) const {
        for (std::size_t i = first_[tile]; i < first_[tile + 1]; ++i)
            if (const GeometryHit& hit = samples_[i].hit;
                std::isfinite(hit.distance_m) && hit.instance == instance && hit.matte)
                found.push_back(&samples_[i]);
    }

    ToLinear to_linear_;
    int columns_, rows_;
    std::vector<LitSample> samples_;
    std::vector<std::size_t> first_;
};

/// Light that the samples received, for a point between them: those that face the same way and are near count most.
glm::vec3 light_at(const std::vector<const LitSample*>& samples, Pixel pixel, const glm::vec3& normal) {
    glm::vec3 seen(0), base(0);
    for (const LitSample* sample : samples) {
        const float dx = float(sample->pixel.x - pixel.x), dy = float(sample->pixel.y - pixel.y);
        const float facing = std::max(glm::dot(sample->hit.normal, normal), 0.0f);
        const float weight = (facing * facing * facing * facing + min_light_weight) / (dx * dx + dy * dy);
        seen += weight * sample->seen;
        base += weight * glm::max(sample->hit.base_colour, glm::vec3(min_base));
    }
    return seen / base;
}

GeometryRay ray_through(const EyeView& eye, int x, int y) {
    return {glm::vec3(eye.pose.position_m), glm::vec3(eye.pose.orientation * eye.camera.direction(x + 0.5, y + 0.5)),
            float(eye.camera.pixel_angle_rad())};
}

std::uint8_t display(float linear) {
    return std::uint8_t(255 * linear_to_srgb(std::clamp(linear, 0.0f, 1.0f)) + 0.5f);
}

/// All rays at once, so that the caster can pack them.
std::vector<GeometryHit> cast(GeometryColour& geometry, const std::vector<GeometryRay>& rays) {
    std::vector<GeometryHit> hits(rays.size());
    geometry.cast(rays, hits);
    return hits;
}

/// The client's own geometry, lit as what is seen of the same instance around a gap: linear colour = base colour there
/// times seen over base colour of the nearest filled pixels of that instance. What shines by itself, mirrors or is
/// glass, what nothing hits, and instances that nothing is seen of nearby stay gaps.
class GeometryPass : public FillPass {
public:
    GeometryPass() : FillPass("geometry", false) {}
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;
};

std::int64_t GeometryPass::fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const {
    if (inputs_.geometry == nullptr || gaps.empty())
        return 0;
    LitSamples samples(picture, gaps);
    std::vector<GeometryRay> rays;
    for (const LitSample& sample : samples.all())
        rays.push_back(ray_through(eye, sample.pixel.x, sample.pixel.y));
    std::vector<Pixel> open;
    for (const GapSpan& span : gaps.spans())
        for (int x = span.begin; x < span.end; ++x) {
            open.push_back({x, span.y});
            rays.push_back(ray_through(eye, x, span.y));
        }
    const std::vector<GeometryHit> hits = cast(*inputs_.geometry, rays);
    for (std::size_t i = 0; i < samples.all().size(); ++i)
        samples.all()[i].hit = hits[i];

    std::atomic<std::int64_t> filled{0};
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, open.size(), 256), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const GeometryHit& hit = hits[samples.all().size() + i];
            if (!std::isfinite(hit.distance_m) || !hit.matte)
                continue;
            const Pixel pixel = open[i];
            const std::vector<const LitSample*> around = samples.around(pixel, hit.instance);
            if (around.empty())
                continue;
            const glm::vec3 linear =
                light_at(around, pixel, hit.normal) * glm::max(hit.base_colour, glm::vec3(min_base));
            std::uint8_t* rgba = picture.rgba.pixel(pixel.x, pixel.y);
            rgba[0] = display(linear.r);
            rgba[1] = display(linear.g);
            rgba[2] = display(linear.b);
            rgba[3] = 255;
            if (!picture.depth_m.empty())
                *picture.depth_m.pixel(pixel.x, pixel.y) = hit.distance_m;
            ++filled;
        }
    });
    // Marked last: while the others are coloured, what is filled and what is not must not change.
    for (const Pixel& pixel : open)
        if (picture.rgba.pixel(pixel.x, pixel.y)[3] != 0)
            *picture.origin.pixel(pixel.x, pixel.y) = std::uint8_t(PixelOrigin::geometry);
    gaps.narrow(picture.origin.view());
    return filled;
}

}  // namespace

std::unique_ptr<FillPass> make_geometry_pass() {
    return std::make_unique<GeometryPass>();
}

}  // namespace equistream
