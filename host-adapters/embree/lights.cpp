#include "lights.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace equistream::embree_host {

SunLight::SunLight(const glm::vec3& direction, const glm::vec3& irradiance, float angular_radius_rad)
    : towards(glm::normalize(direction)), frame(towards) {
    const float radius = std::max(angular_radius_rad, 0.0002f);
    const float half_sine = std::sin(0.5f * radius), sine = std::sin(radius);
    one_minus_cos = 2 * half_sine * half_sine;
    pdf = 1 / (2 * pi_f * one_minus_cos);
    radiance = irradiance / (pi_f * sine * sine);
}

void EmitterTable::add_instance(const ShadingScene& scene, std::uint32_t index, const glm::mat4& world_from_object) {
    const Instance& instance = scene.model().instances[index];
    const Mesh& mesh = scene.model().meshes[instance.mesh];
    const auto world = [&](std::uint32_t vertex) {
        return glm::vec3(world_from_object * glm::vec4(mesh.positions[vertex], 1));
    };
    const bool mirrored = glm::determinant(glm::mat3(world_from_object)) < 0;
    const std::uint32_t mask = scene.model().mask_of(mesh);
    for (const glm::uvec3& t : mesh.triangles) {
        Triangle triangle{};
        triangle.a = world(t.x);
        triangle.ab = world(t.y) - triangle.a;
        triangle.ac = world(t.z) - triangle.a;
        triangle.mask = mask == no_index ? nullptr : &scene.model().alpha_masks[mask];
        triangle.material = scene.material_of(index);
        triangle.area = 0.5f * glm::length(glm::cross(triangle.ab, triangle.ac));
        triangle.mirrored = mirrored;
        if (!mesh.uvs.empty()) {
            triangle.uv_a = mesh.uvs[t.x];
            triangle.uv_ab = mesh.uvs[t.y] - triangle.uv_a;
            triangle.uv_ac = mesh.uvs[t.z] - triangle.uv_a;
        }
        if (triangle.area > 0)
            triangles_.push_back(triangle);
    }
}

void EmitterTable::build(ShadingScene& scene, std::span<const glm::mat4> world_from_object, const Textures& textures) {
    triangles_.clear();
    std::vector<double> brightness;
    for (ShadingMaterial& m : scene.materials()) {
        const glm::vec3 texture = m.emission_texture == no_index ? glm::vec3(1) : textures.mean(m.emission_texture);
        brightness.push_back(m.emits ? luminance(m.emission * texture) : 0);
        m.emission_pdf_area = 0;
    }
    for (std::uint32_t i = 0; i < world_from_object.size(); ++i)
        if (brightness[scene.material_of(i)] > 0)
            add_instance(scene, i, world_from_object[i]);
    std::vector<double> powers;
    double total = 0;
    for (const Triangle& triangle : triangles_) {
        powers.push_back(brightness[triangle.material] * triangle.area);
        total += powers.back();
    }
    if (triangles_.empty())
        return;
    for (std::size_t m = 0; m < brightness.size(); ++m)
        scene.materials()[m].emission_pdf_area = static_cast<float>(brightness[m] / total);
    build_alias_table(powers, total);
}

void EmitterTable::build_alias_table(const std::vector<double>& powers, double total) {
    const std::size_t n = powers.size();
    keep_.assign(n, 1);
    alias_.assign(n, 0);
    std::vector<double> share(n);
    std::vector<std::uint32_t> small, large;
    for (std::uint32_t i = 0; i < n; ++i) {
        share[i] = powers[i] / total * static_cast<double>(n);
        (share[i] < 1 ? small : large).push_back(i);
    }
    while (!small.empty() && !large.empty()) {
        const std::uint32_t s = small.back(), l = large.back();
        small.pop_back();
        keep_[s] = static_cast<float>(share[s]);
        alias_[s] = l;
        share[l] -= 1 - share[s];
        if (share[l] < 1) {
            large.pop_back();
            small.push_back(l);
        }
    }
}

EmitterSample EmitterTable::sample(double choice, const glm::vec2& u) const {
    const double scaled = choice * static_cast<double>(triangles_.size());
    std::size_t i = std::min(static_cast<std::size_t>(scaled), triangles_.size() - 1);
    if (scaled - static_cast<double>(i) >= double(keep_[i]))
        i = alias_[i];
    const Triangle& t = triangles_[i];
    const glm::vec2 b = sample_triangle(u);
    const glm::vec3 wound = glm::normalize(glm::cross(t.ab, t.ac));
    const glm::vec2 uv = t.uv_a + b.x * t.uv_ab + b.y * t.uv_ac;
    return {t.a + b.x * t.ab + b.y * t.ac, t.mirrored ? -wound : wound, uv, t.material,
            t.mask != nullptr && !t.mask->covers(uv)};
}

namespace {

constexpr LongitudeLatitudeRange full_sphere;

glm::vec3 rgb(const FloatImage& image, int x, int y) {
    const float* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}

void scale_pixels(FloatImage& image, const glm::vec3& scale) {
    tbb::parallel_for(0, image.height(), [&](int y) {
        for (int x = 0; x < image.width(); ++x)
            for (int c = 0; c < 3; ++c)
                image.pixel(x, y)[c] *= scale[c];
    });
}

/// Half the size, each pixel the mean over its solid angle; an odd side's last row or column joins its neighbours.
FloatImage halve(const FloatImage& image) {
    FloatImage half(std::max(1, image.width() / 2), std::max(1, image.height() / 2), 3);
    tbb::parallel_for(0, half.height(), [&](int y) {
        const auto part = [](std::int64_t i, int count, int of) { return static_cast<int>(i * of / count); };
        const int y0 = part(y, half.height(), image.height()), y1 = part(y + 1, half.height(), image.height());
        for (int x = 0; x < half.width(); ++x) {
            const int x0 = part(x, half.width(), image.width()), x1 = part(x + 1, half.width(), image.width());
            glm::dvec3 sum{0};
            double weights = 0;
            for (int sy = y0; sy < y1; ++sy) {
                const double weight = equirect_pixel_solid_angle(sy, image.width(), image.height(), full_sphere);
                for (int sx = x0; sx < x1; ++sx)
                    sum += weight * glm::dvec3(rgb(image, sx, sy));
                weights += weight * (x1 - x0);
            }
            for (int c = 0; c < 3; ++c)
                half.pixel(x, y)[c] = static_cast<float>(sum[c] / weights);
        }
    });
    return half;
}

/// Running sums as shares of the total, from 0 to exactly 1; the total.
double to_shares(std::span<const double> weights, std::span<float> steps) {
    double total = 0;
    for (const double weight : weights)
        total += weight;
    double sum = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        steps[i] = total > 0 ? static_cast<float>(sum / total) : 0;
        sum += weights[i];
    }
    steps[weights.size()] = 1;
    return total;
}

struct Choice {
    int index;
    float share;     // of the total
    float fraction;  // of the way through the chosen step
};

Choice choose(std::span<const float> steps, float u) {
    // The last step that begins at or below u and is not empty.
    const auto after = std::upper_bound(steps.begin() + 1, steps.end() - 1, u);
    const auto index = static_cast<std::size_t>(after - steps.begin() - 1);
    const float share = steps[index + 1] - steps[index];
    return {static_cast<int>(index), share, share > 0 ? std::clamp((u - steps[index]) / share, 0.0f, 1.0f) : 0.5f};
}

int wrapped(int x, int width) {
    const int m = x % width;
    return m < 0 ? m + width : m;
}

}  // namespace

SkyLight::SkyLight(FloatImage image, double rotation_rad, const glm::vec3& scale)
    : cos_rotation_(static_cast<float>(std::cos(rotation_rad))),
      sin_rotation_(static_cast<float>(std::sin(rotation_rad))) {
    assert(image.channels() == 3 && !image.empty());
    scale_pixels(image, scale);
    levels_.push_back(std::move(image));
    build_distribution();
    while (levels_.back().height() > 1)
        levels_.push_back(halve(levels_.back()));
}

std::span<const float> SkyLight::row_steps(int y) const {
    const auto length = static_cast<std::size_t>(levels_[0].width()) + 1;
    return std::span(steps_in_rows_).subspan(static_cast<std::size_t>(y) * length, length);
}

void SkyLight::build_distribution() {
    const FloatImage& image = levels_[0];
    const int width = image.width(), height = image.height();
    const auto rows = static_cast<std::size_t>(height), length = static_cast<std::size_t>(width) + 1;
    steps_of_rows_.resize(rows + 1);
    steps_in_rows_.resize(rows * length);
    inverse_pixel_sr_.resize(rows);
    std::vector<double> powers(rows);
    tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t y) {
        std::vector<double> luminances(length - 1);
        for (int x = 0; x < width; ++x)
            luminances[static_cast<std::size_t>(x)] = luminance(rgb(image, x, static_cast<int>(y)));
        const double solid_angle = equirect_pixel_solid_angle(static_cast<int>(y), width, height, full_sphere);
        inverse_pixel_sr_[y] = static_cast<float>(1 / solid_angle);
        powers[y] = solid_angle * to_shares(luminances, std::span(steps_in_rows_).subspan(y * length, length));
    });
    black_ = !(to_shares(powers, steps_of_rows_) > 0);
    for (int y = 0; y <= height; ++y)
        row_sines_.push_back(std::sin(pi * (0.5 - static_cast<double>(y) / height)));
}

Vector3<float> SkyLight::to_image(const glm::vec3& d) const {
    return {cos_rotation_ * d.x - sin_rotation_ * d.z, d.y, sin_rotation_ * d.x + cos_rotation_ * d.z};
}

SkyLight::Pixel SkyLight::pixel_at(const glm::vec3& direction) const {
    const FloatImage& image = levels_[0];
    const auto p = equirect_pixel(to_image(direction), image.width(), image.height(), full_sphere);
    return {wrapped(static_cast<int>(p.u), image.width()), std::clamp(static_cast<int>(p.v), 0, image.height() - 1)};
}

glm::vec3 SkyLight::radiance(const glm::vec3& direction) const {
    const Pixel pixel = pixel_at(direction);
    return rgb(levels_[0], pixel.x, pixel.y);
}

float SkyLight::pixel_pdf(const Pixel& pixel) const {
    const auto x = static_cast<std::size_t>(pixel.x), y = static_cast<std::size_t>(pixel.y);
    const std::span<const float> row = row_steps(pixel.y);
    return (steps_of_rows_[y + 1] - steps_of_rows_[y]) * (row[x + 1] - row[x]) * inverse_pixel_sr_[y];
}

float SkyLight::pdf(const glm::vec3& direction) const {
    return black_ ? 0 : pixel_pdf(pixel_at(direction));
}

SkySample SkyLight::sample(const glm::vec2& u) const {
    assert(!black_);
    const Choice row = choose(steps_of_rows_, u.y);
    const Choice column = choose(row_steps(row.index), u.x);
    const auto y = static_cast<std::size_t>(row.index);
    const double sine = row_sines_[y] + double{row.fraction} * (row_sines_[y + 1] - row_sines_[y]);
    const auto cosine = static_cast<float>(std::sqrt((1 - sine) * (1 + sine)));
    const auto turns = (static_cast<float>(column.index) + column.fraction) / static_cast<float>(levels_[0].width());
    const float longitude = pi_f * (2 * turns - 1);
    const float x = cosine * std::sin(longitude), z = -cosine * std::cos(longitude);
    SkySample s;
    s.direction = {cos_rotation_ * x + sin_rotation_ * z, static_cast<float>(sine),
                   cos_rotation_ * z - sin_rotation_ * x};
    s.radiance = rgb(levels_[0], column.index, row.index);
    s.pdf = row.share * column.share * inverse_pixel_sr_[y];
    return s;
}

glm::vec3 SkyLight::filtered(const glm::vec3& direction, float spread_rad, const glm::vec3& jitter) const {
    const float spread_pixels = spread_rad * static_cast<float>(levels_[0].height() / pi);
    const auto coarsest = static_cast<int>(levels_.size()) - 1;
    const float level = std::log2(std::max(spread_pixels, 1.0f)) + jitter.z;
    const FloatImage& image = levels_[static_cast<std::size_t>(std::min(static_cast<int>(level), coarsest))];
    const auto p = equirect_pixel(to_image(direction), image.width(), image.height(), full_sphere);
    int x = static_cast<int>(std::floor(p.u + jitter.x - 0.5f)),
        y = static_cast<int>(std::floor(p.v + jitter.y - 0.5f));
    if (y < 0 || y >= image.height()) {  // over the pole and down the other side
        y = y < 0 ? -1 - y : 2 * image.height() - 1 - y;
        x += image.width() / 2;
    }
    return rgb(image, wrapped(x, image.width()), y);
}

}  // namespace equistream::embree_host
