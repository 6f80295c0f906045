#include "frame_job.h"

#include <equistream/error.h>
#include <equistream/threads.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <mutex>
#include <string>

namespace equistream::embree_host {
namespace {

/// A thread's worker and the arrays it reuses from tile to tile.
class TileRenderer {
public:
    explicit TileRenderer(const FrameJob& job) : job_(job), worker_(*job.scene) {}

    /// Returns how many paths that took.
    std::uint64_t render(const es_tile& tile) {
        rays_.resize(tile.pixel_count);
        answer_probes(tile);
        if (job_.wants_surfaces) {
            surfaces_.resize(tile.pixel_count);
            const auto rays = asked(es_tile_geometry_rays(job_.frame, &tile, rays_.data()));
            trace_surfaces(worker_, {job_.scene->shading, job_.neighbours}, rays,
                           std::span(surfaces_).first(rays.size()));
            es_tile_put_surfaces(job_.frame, &tile, surfaces_.data());
        }
        rgba_.resize(std::size_t{tile.pixel_count} * 4);
        guides_.resize(job_.wants_guides ? std::size_t{tile.pixel_count} * 6 : 0);
        ids_.resize(job_.wants_ids ? std::size_t{tile.pixel_count} * 2 : 0);
        std::uint64_t paths = 0;
        for (std::uint32_t sample = 0; sample < tile.sample_count; ++sample) {
            const auto rays = asked(es_tile_colour_rays(job_.frame, &tile, sample, rays_.data()));
            if (sample == 0)
                keep_pixel_seeds(rays);
            worker_.trace_radiance(rays, pixel_seeds_, sample, std::span(rgba_).first(4 * rays.size()),
                                   std::span(guides_).first(job_.wants_guides ? 6 * rays.size() : 0),
                                   std::span(ids_).first(job_.wants_ids ? 2 * rays.size() : 0));
            es_tile_put_radiance(job_.frame, &tile, rgba_.data());
            if (job_.wants_guides)
                es_tile_put_guides(job_.frame, &tile, guides_.data());
            if (job_.wants_ids)
                es_tile_put_ids(job_.frame, &tile, ids_.data());
            paths += rays.size();
        }
        return paths;
    }
    RayCounts counts() const { return worker_.counts(); }

private:
    std::span<const es_ray> asked(std::uint32_t count) const { return std::span(rays_).first(count); }

    /// What a hidden layer must know before its colour.
    void answer_probes(const es_tile& tile) {
        while (const std::uint32_t count = es_tile_probe_rays(job_.frame, &tile, rays_.data())) {
            worker_.trace_coherent(asked(count), hits_);
            distances_m_.resize(count);
            for (std::size_t i = 0; i < count; ++i)
                distances_m_[i] =
                    hits_[i].id.instance == no_index ? std::numeric_limits<float>::infinity() : hits_[i].distance;
            es_tile_put_distances(job_.frame, &tile, distances_m_.data());
            worker_.end_surfaces();
        }
    }

    /// The first sample's seeds scramble the pixels' sequences; the ABI promises that they differ between pixels.
    void keep_pixel_seeds(std::span<const es_ray> rays) {
        pixel_seeds_.resize(rays.size());
        for (std::size_t i = 0; i < rays.size(); ++i)
            pixel_seeds_[i] = rays[i].seed;
    }

    const FrameJob& job_;
    Worker worker_;
    std::vector<es_ray> rays_;
    std::vector<Worker::Hit> hits_;
    std::vector<float> distances_m_;
    std::vector<es_surface> surfaces_;
    std::vector<std::uint64_t> pixel_seeds_;
    std::vector<float> rgba_, guides_;
    std::vector<std::uint32_t> ids_;
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
                job.paths_traced(renderer.render(tile));
            }
            const std::lock_guard lock(mutex);
            total += renderer.counts();
        } catch (...) {
            const std::lock_guard lock(mutex);
            failed = true;
            failure = std::current_exception();
        }
    };
    start_threads(job.threads, work).clear();  // waits for them
    if (failure)
        std::rethrow_exception(failure);
    return total;
}

void cast_rays(const TracedScene& scene, unsigned threads, std::span<const es_ray> rays, std::span<float> distances_m) {
    constexpr std::size_t piece = 4096;
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        Worker worker(scene);
        std::vector<Worker::Hit> hits;
        for (std::size_t begin = next.fetch_add(piece); begin < rays.size(); begin = next.fetch_add(piece)) {
            const auto part = rays.subspan(begin, std::min(piece, rays.size() - begin));
            worker.trace_coherent(part, hits);
            for (std::size_t i = 0; i < part.size(); ++i)
                distances_m[begin + i] =
                    hits[i].id.instance == no_index ? std::numeric_limits<float>::infinity() : hits[i].distance;
        }
    };
    // None of it on the caller's thread: tracing changes how a thread rounds.
    const auto helpers = start_threads(threads, work);
}

}  // namespace equistream::embree_host
