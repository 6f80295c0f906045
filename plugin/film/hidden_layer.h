#pragma once
/// The hidden layer of one frame while a host renders it: what tiles ask before their colour, and which of their pixels
/// they turn out to have.
#include "hidden_search.h"
#include "rays.h"

#include <mutex>
#include <unordered_map>
#include <vector>

namespace equistream {

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
