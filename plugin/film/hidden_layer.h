#pragma once
/// Whether something lies behind a pixel's first surface that an eye of the head box sees past it, and how far: found
/// by asking for distances, one ray after another.
///
/// Along the ray, surfaces that differ from the first one by more than the error budget e in w = B / (r - B) are tried
/// in turn, the nearest first, the sky last. One counts if an eye sees it: eyes stand on the rim of the disc of radius
/// B across the ray (on an octagon around it, so that no straight edge uncovers more than they do) and halfway out.
/// Those on the rim stand farther out by what uncovers another half a pixel, 2 B at most: a pixel counts as soon as an
/// edge uncovers some of it. What no eye sees, such as most of the back of a closed object, is passed.
/// docs/conventions.md, "Hidden layer".
#include "rays.h"

#include <equistream/equistream.h>

#include <glm/glm.hpp>

#include <cstdint>
#include <mutex>
#include <unordered_map>
#include <vector>

namespace equistream {

/// What all pixels of a frame share.
struct HeadBox {
    glm::dvec3 centre_m{0};  ///< the camera's place
    double radius_m = 0;     ///< B; nothing is hidden from a single point
};

/// Surfaces behind the first one that are tried at most.
inline constexpr int max_surfaces_behind = 8;

/// One pixel's search; a plain value.
class HiddenSearch {
public:
    bool is_done() const { return step_ == Step::found || step_ == Step::none; }
    /// Where along the pixel's ray a ray begins that meets the hidden surface and nothing before it: half-way in w
    /// between it and what is in front. NaN where there is none.
    float begin_m() const;

    /// The next ray to trace, given the pixel's own; not when done.
    es_ray question(const es_ray& pixel_ray, const HeadBox& box) const;
    /// How far that ray goes: +inf for a miss.
    void answer(float distance_m, const es_ray& pixel_ray, const HeadBox& box);

private:
    enum class Step : std::uint8_t { first, behind, seen, found, none };

    void look_behind(double step_w, const HeadBox& box);
    glm::dvec3 eye_offset_m(const es_ray& pixel_ray, const HeadBox& box) const;
    double distance_from_eye_m(const es_ray& pixel_ray, const HeadBox& box) const;

    float first_m_ = 0;
    float front_m_ = 0;   ///< the last surface that was passed
    float behind_m_ = 0;  ///< of the ray that looks behind it; then the surface tried
    std::uint8_t surfaces_ = 0, eye_ = 0;
    Step step_ = Step::first;
};

// The hidden layer of one frame while a host renders it: what tiles ask before their colour, and which of their pixels
// they turn out to have.

/// Tiles may be searched by any number of threads, each tile by one at a time.
class HiddenLayer {
public:
    explicit HiddenLayer(const HeadBox& box) : box_(box) {}

    /// Fills the rays that `tile` asks next and returns how many; 0: it knows all it needs.
    std::uint32_t ask(const es_tile& tile, const FrameRays& rays, es_ray* out);
    /// Answers to the last ask(). False, changing nothing, when none are awaited.
    bool tell(const es_tile& tile, const FrameRays& rays, const float* distances_m);

    /// Pixels of a tile that the layer has.
    struct Found {
        std::vector<std::uint32_t> pixels;  ///< within the tile, row by row, ascending
        std::vector<float> begin_m;         ///< where their rays begin
    };
    /// Null until the tile has been searched.
    const Found* found(const es_tile& tile) const;

private:
    struct Search {
        std::vector<HiddenSearch> pixels;
        std::vector<std::uint32_t> asked;
    };
    Search& search_of(const es_tile& tile);
    void finish(const es_tile& tile, const Search& search);

    HeadBox box_;
    mutable std::mutex mutex_;  // of the tables; what they hold belongs to the tile's thread
    std::unordered_map<std::uint32_t, Search> searches_;
    std::unordered_map<std::uint32_t, Found> found_;
};

}  // namespace equistream
