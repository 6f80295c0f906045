#pragma once
/// Collects what a host answers, tile by tile, into the planes of one frame.
#include "motion.h"

#include <equistream/aov.h>
#include <equistream/equistream.h>
#include <equistream/frame.h>

#include <atomic>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace equistream {

/// Camera poses of a frame and its neighbours.
struct FramePoses {
    Pose previous, here, next;
};

/// Tiles may be filled by any number of threads, each tile by one at a time; the rest is for one thread.
class Film {
public:
    /// `planes` are names of the AOV catalogue, colour among them.
    Film(const Camera& camera, const FramePoses& poses, std::uint32_t samples_per_pixel,
         std::vector<std::string> planes);

    /// Hands out each tile once.
    std::optional<es_tile> next_tile();
    /// Whether `tile` is one of ours, unchanged.
    bool knows(const es_tile& tile) const;

    void put_surfaces(const es_tile& tile, const es_surface* surfaces);
    /// Adds one colour pass. Samples that are not finite are left out of their pixel's mean.
    /// Returns false, adding nothing, when the tile has had all its passes.
    bool add_radiance(const es_tile& tile, const float* rgba);

    /// Whole planes; they take the place of what tiles say of them. The image must have the right shape.
    void put_plane(const std::string& name, FloatImage image);
    void put_plane(const std::string& name, IdImage image);
    bool wants(const std::string& name) const;
    const std::vector<std::string>& planes() const { return plane_names_; }

    /// What is still missing, in words; nothing when the frame is complete.
    std::optional<std::string> missing() const;
    /// Colour samples that were not finite, of tiles only.
    std::int64_t left_out_samples() const;
    /// Moves the planes into `frame`, averaging colour.
    void finish(Frame& frame);

private:
    struct TileProgress {
        std::uint32_t colour_passes = 0;
        bool surfaces = false;
    };
    es_tile tile(std::uint32_t id) const;
    void start_film();
    FloatImage averaged_colour() const;
    float* real_target(const char* name);
    std::uint32_t* id_target(const char* name);

    Camera camera_;
    int width_;
    int height_;
    std::uint32_t tiles_across_;
    std::uint32_t tile_count_;
    std::uint32_t samples_per_pixel_;
    Motion backward_;
    Motion forward_;
    std::vector<std::string> plane_names_;
    std::set<std::string> whole_;
    std::map<std::string, FloatImage, std::less<>> real_;
    std::map<std::string, IdImage, std::less<>> ids_;

    std::atomic<std::uint32_t> next_tile_{0};
    std::once_flag film_started_;
    std::vector<TileProgress> progress_;
    FloatImage radiance_sum_;
    IdImage left_out_;  ///< colour samples that were not finite, per pixel
};

}  // namespace equistream
