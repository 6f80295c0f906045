#include "frame_planes.h"

#include <equistream/aov.h>
#include <equistream/aov_groups.h>
#include <equistream/error.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream::mitsuba_host {
namespace {

constexpr std::size_t rays_of_a_launch = 1 << 16;
constexpr float miss = std::numeric_limits<float>::infinity();

std::size_t channel_of(const PassResult& pass, std::string_view name) {
    const auto found = std::find(pass.channels.begin(), pass.channels.end(), name);
    if (found == pass.channels.end())
        throw WorkError(expected_found("equirect_aov", "a channel " + std::string(name), "none"));
    return static_cast<std::size_t>(found - pass.channels.begin());
}

void put(es_frame* frame, const es_plane& plane) {
    es_error error{};
    if (es_frame_put_plane(frame, &plane, &error) != ES_OK)
        throw WorkError(error.text);
}

template <typename Number>
void turn_normal(const WorldMap& world, Number* normal) {
    const glm::dvec3 ours = world.ours_from_mitsuba * glm::dvec3(normal[0], normal[1], normal[2]);
    for (int c = 0; c < 3; ++c)
        normal[c] = static_cast<Number>(ours[c]);
}

}  // namespace

FramePlanes::FramePlanes(int width, int height, std::string_view aovs)
    : width_(width), height_(height), colour_(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      good_samples_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    for (const std::string& name : parse_aov_groups(aovs)) {
        const AovInfo aov = *find_aov(name);
        if (name != "colour" && aov.in_all)
            planes_.push_back({name, static_cast<int>(aov.channels.size()), aov.type == SampleType::id, {}, {}});
    }
}

FramePlanes::Plane* FramePlanes::find(std::string_view name) {
    const auto found = std::find_if(planes_.begin(), planes_.end(), [&](const Plane& p) { return p.name == name; });
    return found == planes_.end() ? nullptr : &*found;
}

void FramePlanes::add(const PassResult& pass, std::uint32_t samples) {
    const std::size_t stride = pass.channels.size();
    for (std::size_t i = 0; i < good_samples_.size(); ++i) {
        const float* rgba = &pass.values[i * stride];
        colour_[4 * i + 3] += static_cast<double>(rgba[3]) * samples;
        if (!std::all_of(rgba, rgba + 3, [](float v) { return std::isfinite(v); })) {
            left_out_ += samples;
            continue;
        }
        for (std::size_t c = 0; c < 3; ++c)
            colour_[4 * i + c] += static_cast<double>(rgba[c]) * samples;
        good_samples_[i] += samples;
    }
    all_samples_ += samples;
    if (stride > 4)
        take_aovs(pass);
    guides_.resize(pass.guides.size());
    for (std::size_t i = 0; i < guides_.size(); ++i)
        guides_[i] += static_cast<double>(pass.guides[i]) * samples;
}

void FramePlanes::take_aovs(const PassResult& pass) {
    const std::size_t stride = pass.channels.size(), pixels = good_samples_.size();
    for (Plane& plane : planes_) {
        const auto channels = find_aov(plane.name)->channels;
        (plane.is_id ? plane.ids.resize(pixels * channels.size()) : plane.values.resize(pixels * channels.size()));
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const std::size_t from = channel_of(pass, channels[c]);
            for (std::size_t i = 0; i < pixels; ++i) {
                const float value = pass.values[i * stride + from];
                if (plane.is_id)
                    plane.ids[i * channels.size() + c] = static_cast<std::uint32_t>(std::max(value, 0.0f));
                else
                    plane.values[i * channels.size() + c] = value;
            }
        }
    }
}

void FramePlanes::bring_home(const WorldMap& world) {
    for (std::size_t i = 0; i < guides_.size(); i += guide_channels)
        turn_normal(world, &guides_[i + 3]);
    for (const char* name : {"depth", "virtual_depth"})
        if (Plane* depth = find(name); depth && world.metres_per_unit != 1)
            for (float& value : depth->values)
                value = static_cast<float>(value * world.metres_per_unit);
    if (Plane* normal = find("normal"))
        for (std::size_t i = 0; i + 2 < normal->values.size(); i += 3)
            turn_normal(world, &normal->values[i]);
    const Plane* object = find("object_id");
    if (!object)
        return;
    for (std::size_t i = 0; i < object->ids.size(); ++i) {
        if (object->ids[i] != no_surface_id)
            continue;
        for (Plane& plane : planes_) {
            const auto channels = static_cast<std::size_t>(plane.channels);
            if (plane.is_id && plane.name != "object_id")
                std::fill_n(&plane.ids[i * channels], channels, 0u);
            else if (plane.name == "depth" || plane.name == "virtual_depth")
                plane.values[i] = miss;
            else if (plane.name == "normal" || plane.name == "albedo" || plane.name == "specular")
                std::fill_n(&plane.values[i * channels], channels, 0.0f);
        }
        find("object_id")->ids[i] = 0;
        colour_[4 * i + 3] = 0;
    }
}

void FramePlanes::hand_over(es_frame* frame, std::string_view aovs, float without_samples) const {
    std::vector<float> colour(colour_.size());
    for (std::size_t i = 0; i < colour.size(); ++i) {
        const double samples = i % 4 == 3 ? all_samples_ : good_samples_[i / 4];
        colour[i] = samples > 0 ? static_cast<float>(colour_[i] / samples) : without_samples;
    }
    const auto row = [&](int channels) {
        return static_cast<std::size_t>(width_) * static_cast<std::size_t>(channels) * sizeof(float);
    };
    put(frame, {sizeof(es_plane), "colour", ES_FLOAT32, 4, colour.data(), row(4)});
    if (!guides_.empty())
        hand_over_guides(frame);
    const std::vector<std::string> wanted = parse_aov_groups(aovs);
    for (const Plane& plane : planes_) {
        if (std::find(wanted.begin(), wanted.end(), plane.name) == wanted.end())
            continue;
        put(frame,
            {sizeof(es_plane), plane.name.c_str(), plane.is_id ? ES_UINT32 : ES_FLOAT32, plane.channels,
             plane.is_id ? static_cast<const void*>(plane.ids.data()) : plane.values.data(), row(plane.channels)});
    }
}

void FramePlanes::hand_over_guides(es_frame* frame) const {
    constexpr const char* names[] = {"guide_albedo", "guide_normal"};
    for (std::size_t guide = 0; guide < 2; ++guide) {
        std::vector<float> mean;
        for (std::size_t i = 0; i < guides_.size(); i += guide_channels)
            for (std::size_t c = 0; c < 3; ++c) {
                const double value = guides_[i + 3 * guide + c] / all_samples_;
                mean.push_back(std::isfinite(value) ? static_cast<float>(value) : 0);
            }
        put(frame, {sizeof(es_plane), names[guide], ES_FLOAT32, 3, mean.data(),
                    static_cast<std::size_t>(width_) * 3 * sizeof(float)});
    }
}

RayBatch TileRays::batch(std::span<const es_ray> rays) const {
    RayBatch batch;
    const glm::dmat3 turned = glm::transpose(world_.ours_from_mitsuba);
    const auto scale = static_cast<float>(1 / world_.metres_per_unit);
    const XmlSensor& sensor = scene_.xml_sensor();
    for (const es_ray& ray : rays) {
        const glm::dvec3 origin = turned * glm::dvec3(ray.origin[0], ray.origin[1], ray.origin[2]);
        const glm::dvec3 direction = turned * glm::dvec3(ray.direction[0], ray.direction[1], ray.direction[2]);
        for (int axis = 0; axis < 3; ++axis) {
            const auto at = static_cast<std::size_t>(axis);
            batch.origin[at].push_back(static_cast<float>(origin[axis] / world_.metres_per_unit));
            batch.direction[at].push_back(static_cast<float>(direction[axis]));
        }
        const double along_axis =
            axis_ == glm::dvec3(0)
                ? 1
                : std::max(1e-6, glm::dot(axis_, glm::dvec3(ray.direction[0], ray.direction[1], ray.direction[2])));
        const float begin = std::max(ray.t_min * scale, static_cast<float>(sensor.near_clip / along_axis));
        const float end = std::min(ray.t_max * scale, static_cast<float>(sensor.far_clip / along_axis));
        batch.begin.push_back(begin);
        batch.end.push_back(std::max(begin, end));
    }
    return batch;
}

std::vector<float> TileRays::guides(const RayBatch& rays) const {
    std::vector<float> guides = scene_.guides(rays);
    for (std::size_t i = 0; i < guides.size(); i += guide_channels)
        turn_normal(world_, &guides[i + 3]);
    guides.resize(std::max(guides.size(), guide_channels));  // no pointer to nothing
    return guides;
}

std::vector<float> TileRays::distances_m(std::span<const es_ray> rays) {
    std::vector<float> distances = scene_.distances(batch(rays));
    for (float& distance : distances)
        distance *= static_cast<float>(world_.metres_per_unit);
    return distances;
}

void TileRays::put_distances(es_frame* frame, const es_tile& tile) {
    const std::uint32_t pixels = es_tile_geometry_rays(frame, &tile, rays_.data());
    std::vector<es_surface> surfaces(tile.pixel_count);
    const std::vector<float> distances = distances_m(asked(pixels));
    for (std::uint32_t i = 0; i < pixels; ++i)
        surfaces[i].distance_m = distances[i];
    es_tile_put_surfaces(frame, &tile, surfaces.data());
}

std::uint64_t TileRays::render(const render_command::FrameTask& task, std::size_t sensor, bool ids_alone,
                               const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& seed_of) {
    es_tile tile;
    std::uint64_t left_out = 0;
    while (!*task.stop) {
        const es_status status = es_frame_next_tile(task.frame, &tile);
        if (status == ES_DONE)
            break;
        if (status != ES_OK)
            throw WorkError("libequistream could not hand out the frame's next tile (status " + std::to_string(status) +
                            ")");
        rays_.resize(tile.pixel_count);
        while (const std::uint32_t count = es_tile_probe_rays(task.frame, &tile, rays_.data()))
            es_tile_put_distances(task.frame, &tile, distances_m(asked(count)).data());
        if (!ids_alone)
            put_distances(task.frame, tile);
        std::vector<es_ray> rays;
        for (std::uint32_t sample = 0; sample < tile.sample_count && !*task.stop;) {
            // Passes of a small tile go together: each launch costs.
            rays.clear();
            const std::uint32_t first = sample;
            std::uint32_t count = 0;
            do {
                count = es_tile_colour_rays(task.frame, &tile, sample++, rays_.data());
                rays.insert(rays.end(), rays_.begin(), rays_.begin() + count);
            } while (sample < tile.sample_count && rays.size() + count <= rays_of_a_launch);
            const RayBatch traced = batch(rays);
            if (task.stream->wants_ids()) {
                std::vector<std::uint32_t> ids = scene_.ids(traced);
                ids.resize(std::max<std::size_t>(ids.size(), 2));
                for (std::size_t pass = 0; pass < sample - first; ++pass)
                    es_tile_put_ids(task.frame, &tile, &ids[pass * count * 2]);
            }
            if (ids_alone)
                continue;
            std::vector<float> rgba = scene_.radiance(traced, sensor, seed_of(tile.id, first));
            for (std::size_t i = 0; i < rgba.size(); i += 4)
                left_out += !std::all_of(&rgba[i], &rgba[i] + 4, [](float v) { return std::isfinite(v); });
            rgba.resize(std::max<std::size_t>(rgba.size(), 4));  // no pointer to nothing
            for (std::size_t pass = 0; pass < sample - first; ++pass)
                es_tile_put_radiance(task.frame, &tile, &rgba[pass * count * 4]);
            if (task.stream->wants_guides()) {
                const std::vector<float> all = guides(traced);
                for (std::size_t pass = 0; pass < sample - first; ++pass)
                    es_tile_put_guides(task.frame, &tile, &all[pass * count * guide_channels]);
            }
            task.paths_traced(rays.size());
        }
    }
    return left_out;
}

}  // namespace equistream::mitsuba_host
