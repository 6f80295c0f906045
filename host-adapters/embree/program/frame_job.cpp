#include "frame_job.h"

#include <equistream/error.h>

#include <exception>
#include <mutex>
#include <string>
#include <thread>

namespace equistream::embree_host {
namespace {

/// A thread's worker and the arrays it reuses from tile to tile.
class TileRenderer {
public:
    explicit TileRenderer(const FrameJob& job) : job_(job), worker_(*job.scene) {}

    void render(const es_tile& tile) {
        rays_.resize(tile.pixel_count);
        if (job_.wants_surfaces) {
            surfaces_.resize(tile.pixel_count);
            es_tile_geometry_rays(job_.frame, &tile, rays_.data());
            trace_surfaces(worker_, job_.scene->shading, job_.neighbours, rays_, surfaces_);
            es_tile_put_surfaces(job_.frame, &tile, surfaces_.data());
        }
        rgba_.resize(std::size_t{tile.pixel_count} * 4);
        for (std::uint32_t sample = 0; sample < tile.sample_count; ++sample) {
            es_tile_colour_rays(job_.frame, &tile, sample, rays_.data());
            if (sample == 0)
                keep_pixel_seeds();
            worker_.trace_radiance(rays_, pixel_seeds_, sample, rgba_);
            es_tile_put_radiance(job_.frame, &tile, rgba_.data());
        }
    }
    RayCounts counts() const { return worker_.counts(); }

private:
    /// The first sample's seeds scramble the pixels' sequences; the ABI promises that they differ between pixels.
    void keep_pixel_seeds() {
        pixel_seeds_.resize(rays_.size());
        for (std::size_t i = 0; i < rays_.size(); ++i)
            pixel_seeds_[i] = rays_[i].seed;
    }

    const FrameJob& job_;
    Worker worker_;
    std::vector<es_ray> rays_;
    std::vector<es_surface> surfaces_;
    std::vector<std::uint64_t> pixel_seeds_;
    std::vector<float> rgba_;
};

/// False when there are no more.
bool next_tile(es_frame* frame, es_tile& tile) {
    const es_status status = es_frame_next_tile(frame, &tile);
    if (status != ES_OK && status != ES_DONE)
        throw WorkError("libequistream could not hand out the frame's next tile (status " + std::to_string(status) +
                        ")");
    return status == ES_OK;
}

}  // namespace

RayCounts run_frame(const FrameJob& job) {
    std::mutex mutex;
    RayCounts total;
    std::exception_ptr failure;
    std::atomic<bool> failed = false;
    const auto work = [&] {
        try {
            TileRenderer renderer(job);
            es_tile tile;
            while (!*job.stop && !failed && next_tile(job.frame, tile)) {
                renderer.render(tile);
                job.paths_traced(std::uint64_t{tile.pixel_count} * tile.sample_count);
            }
            const std::lock_guard lock(mutex);
            total += renderer.counts();
        } catch (...) {
            const std::lock_guard lock(mutex);
            failed = true;
            failure = std::current_exception();
        }
    };
    {
        std::vector<std::jthread> threads;
        for (unsigned i = 0; i < job.threads; ++i)
            threads.emplace_back(work);
    }
    if (failure)
        std::rethrow_exception(failure);
    return total;
}

}  // namespace equistream::embree_host
