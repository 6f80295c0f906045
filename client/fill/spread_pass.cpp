#include "fill.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream {

namespace {

/// Depths whose ratio is below about 1.1 are one surface, whatever the head box: what colours come from is a guess
/// anyway, which the bound says nothing of.
constexpr float same_surface_likeness = 0.1f;
/// By which squares of depths' relative differences count.
constexpr float likeness_steepness = 1e3f;
/// Where one of both is infinite, or not known.
constexpr float min_likeness = 1e-6f;

/// How much a gap pixel and its neighbour are taken for one surface: 1 at the same depth, less the more the depths'
/// ratio differs from one; never quite 0.
float depth_likeness(float a_m, float b_m) {
    if (a_m == b_m)
        return 1;
    const float difference = std::abs(a_m - b_m) / std::min(a_m, b_m);
    return std::isfinite(difference) ? 1 / (1 + likeness_steepness * difference * difference) : min_likeness;
}

struct Pixel {
    int x = 0, y = 0;
    bool operator==(const Pixel&) const = default;
};

constexpr std::array<Pixel, 8> around = {{{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

/// One layer after the other: the colours of a layer come from the layers before it only, so the result does not
/// depend on the order within it.
class Spreader {
public:
    Spreader(const EyeView& eye, EyePicture& picture, const Gaps& gaps) : eye_(eye), picture_(picture), gaps_(gaps) {}

    /// First within surfaces only, so that a foreground does not grow into the background that it uncovered; then
    /// whatever is left, from any neighbour.
    std::int64_t run() {
        across_surfaces_ = false;
        const std::int64_t within = spread();
        across_surfaces_ = true;
        return within + spread();
    }

private:
    std::int64_t spread() {
        std::int64_t filled = 0;
        std::vector<Pixel> layer = fillable(all_open());
        while (!layer.empty()) {
            colour(layer);
            filled += std::int64_t(layer.size());
            layer = fillable(open_around(layer));
        }
        return filled;
    }

    bool inside(Pixel p) const {
        return p.x >= 0 && p.y >= 0 && p.x < picture_.origin.width() && p.y < picture_.origin.height();
    }
    bool open(Pixel p) const { return picture_.origin.pixel(p.x, p.y)[0] == std::uint8_t(PixelOrigin::gap); }
    bool gives(Pixel from, Pixel to) const {
        return inside(from) && !open(from) && (across_surfaces_ || likeness(from, to) > same_surface_likeness);
    }

    float likeness(Pixel a, Pixel b) const {
        if (eye_.depth_m.data == nullptr)
            return 1;
        return depth_likeness(eye_.depth_m.pixel(a.x, a.y)[0], eye_.depth_m.pixel(b.x, b.y)[0]);
    }

    std::vector<Pixel> all_open() const {
        std::vector<Pixel> pixels;
        for (const GapSpan& span : gaps_.spans())
            for (int x = span.begin; x < span.end; ++x)
                if (open({x, span.y}))
                    pixels.push_back({x, span.y});
        return pixels;
    }

    std::vector<Pixel> open_around(const std::vector<Pixel>& layer) const {
        std::vector<Pixel> next;
        for (const Pixel& p : layer)
            for (const Pixel& step : around) {
                const Pixel n{p.x + step.x, p.y + step.y};
                if (inside(n) && open(n))
                    next.push_back(n);
            }
        std::ranges::sort(next, [](Pixel a, Pixel b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
        next.erase(std::unique(next.begin(), next.end()), next.end());
        return next;
    }

    std::vector<Pixel> fillable(std::vector<Pixel> pixels) const {
        std::erase_if(pixels, [&](Pixel p) {
            return std::ranges::none_of(around, [&](Pixel step) { return gives({p.x + step.x, p.y + step.y}, p); });
        });
        return pixels;
    }

    void colour(const std::vector<Pixel>& layer) {
        std::vector<std::array<float, 3>> colours;
        colours.reserve(layer.size());
        for (const Pixel& p : layer)
            colours.push_back(mean_around(p));
        for (std::size_t i = 0; i < layer.size(); ++i) {
            std::uint8_t* rgba = picture_.rgba.pixel(layer[i].x, layer[i].y);
            std::ranges::transform(colours[i], rgba, [](float c) { return std::uint8_t(c + 0.5f); });
            rgba[3] = 255;
            picture_.origin.pixel(layer[i].x, layer[i].y)[0] = std::uint8_t(PixelOrigin::neighbours);
        }
    }

    std::array<float, 3> mean_around(Pixel p) const {
        float sum = 0;
        std::array<float, 3> mean{};
        for (const Pixel& step : around) {
            const Pixel n{p.x + step.x, p.y + step.y};
            if (!gives(n, p))
                continue;
            const float weight = likeness(p, n);
            sum += weight;
            for (std::size_t c = 0; c < 3; ++c)
                mean[c] += weight * float(picture_.rgba.pixel(n.x, n.y)[c]);
        }
        for (float& c : mean)
            c /= sum;
        return mean;
    }

    const EyeView& eye_;
    EyePicture& picture_;
    const Gaps& gaps_;
    bool across_surfaces_ = false;
};

/// The nearest filled neighbours.
class SpreadPass : public FillPass {
public:
    SpreadPass() : FillPass("spread", false) {}
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override {
        const std::int64_t filled = Spreader(eye, picture, gaps).run();
        gaps.narrow(picture.origin.view());
        return filled;
    }
};

}  // namespace

std::unique_ptr<FillPass> make_spread_pass() {
    return std::make_unique<SpreadPass>();
}

}  // namespace equistream
