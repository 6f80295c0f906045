#pragma once
/// The rays one frame asks its host for.
#include <equistream/equistream.h>
#include <equistream/frame.h>
#include <equistream/patches.h>

#include <mutex>
#include <unordered_map>
#include <vector>

namespace equistream {

/// Immutable after construction; any number of threads.
class FrameRays {
public:
    explicit FrameRays(const FrameInfo& info);

    /// Through the centre of pixel (x, y).
    es_ray geometry(int x, int y) const;
    /// Jittered within it: colour pass `sample`.
    es_ray colour(int x, int y, std::uint32_t sample) const;

private:
    /// A pixel of the picture, and where in its camera's image (or on its auxiliary sphere) a ray goes through it.
    struct Place {
        int x, y;
        double u, v;
    };
    es_ray ray(const glm::vec3& direction_camera, const Place& place, std::uint32_t sample) const;
    glm::vec3 origin(const Place& place) const;
    Place place_of(int x, int y, double u, double v) const;
    std::uint32_t pixel_of(int x, int y) const { return static_cast<std::uint32_t>(y * width_ + x); }
    /// Of a window: the pixel of its sphere; else the pixel itself.
    glm::ivec2 on_sphere(int x, int y) const { return {(x + corner_.x) % width_, y + corner_.y}; }
    glm::vec3 direction_float(float u, float v) const;
    float footprint_rad(const glm::vec3& direction_camera) const;

    Camera camera_;  ///< of a window: its whole sphere's, so that both have the same rays
    glm::ivec2 corner_{0, 0};
    std::optional<PatchAtlas> atlas_;
    int width_;                       ///< of the picture; of a window: of its sphere
    std::vector<glm::vec3> origins_;  ///< by auxiliary sphere; without an atlas the camera's own
    glm::mat3 world_from_camera_;
    std::uint64_t key_;
};

// Which pixels of an atlas's tiles lie in slots that somebody uses. Any number of threads.

class UsedPixels {
public:
    /// Within the tile, row by row, ascending; the list stays where it is. Ask for one atlas only.
    const std::vector<std::uint32_t>& of(const es_tile& tile, const PatchAtlas& atlas) const {
        const std::lock_guard lock(mutex_);
        const auto [known, is_new] = by_tile_.try_emplace(tile.id);
        if (is_new)
            for (std::uint32_t i = 0; i < tile.pixel_count; ++i) {
                const auto pixel = static_cast<int>(i);
                if (atlas.slot_at(tile.x + pixel % tile.width, tile.y + pixel / tile.width).used)
                    known->second.push_back(i);
            }
        return known->second;
    }

private:
    mutable std::mutex mutex_;
    mutable std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> by_tile_;
};

}  // namespace equistream
