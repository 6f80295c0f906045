#include "report.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

namespace equistream::embree_host {
namespace {

/// The most memory this process has held, from the kernel; 0 where it does not say.
double peak_memory_mib() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (word == "VmHWM:") {
            double kibibytes = 0;
            status >> kibibytes;
            return kibibytes / 1024;
        }
    return 0;
}

}  // namespace

void print_report(const RenderReport& r, bool json) {
    const double seconds = std::max(r.render_s, 1e-9);
    const double paths_per_s = static_cast<double>(r.counts.paths) / seconds;
    const std::uint64_t rays = r.counts.path_rays + r.counts.shadow_rays;
    const double rays_per_s = static_cast<double>(rays) / seconds;
    const double peak_mib = peak_memory_mib();
    if (json) {
        const nlohmann::json report = {{"frames_rendered", r.frames_rendered},
                                       {"frames_kept", r.frames_kept},
                                       {"threads", r.threads},
                                       {"load_s", r.load_s},
                                       {"bvh_s", r.bvh_s},
                                       {"render_s", r.render_s},
                                       {"triangles", r.triangles},
                                       {"unique_triangles", r.unique_triangles},
                                       {"bvh_mib", static_cast<double>(r.bvh_bytes) / (1 << 20)},
                                       {"peak_memory_mib", peak_mib},
                                       {"paths", r.counts.paths},
                                       {"path_rays", r.counts.path_rays},
                                       {"shadow_rays", r.counts.shadow_rays},
                                       {"texture_calls", r.counts.texture_calls},
                                       {"left_out_samples", r.counts.not_finite},
                                       {"cpu_s",
                                        {{"camera_rays", r.counts.camera_rays_s},
                                         {"path_rays", r.counts.path_rays_s},
                                         {"shadow_rays", r.counts.shadow_rays_s},
                                         {"shading_and_textures", r.counts.shading_s},
                                         {"film", r.counts.film_s}}},
                                       {"paths_per_s", paths_per_s},
                                       {"rays_per_s", rays_per_s}};
        std::printf("%s\n", report.dump(2).c_str());
        return;
    }
    std::printf("%lld frames rendered, %lld kept\n", static_cast<long long>(r.frames_rendered),
                static_cast<long long>(r.frames_kept));
    std::printf("load %.2f s, BVH %.2f s (%.0f MiB), %.2f M triangles (%.2f M unique), peak memory %.0f MiB\n",
                r.load_s, r.bvh_s, static_cast<double>(r.bvh_bytes) / (1 << 20),
                static_cast<double>(r.triangles) * 1e-6, static_cast<double>(r.unique_triangles) * 1e-6, peak_mib);
    if (r.counts.not_finite > 0)
        std::printf("%llu samples were not finite and are left out\n",
                    static_cast<unsigned long long>(r.counts.not_finite));
    if (r.frames_rendered > 0)
        std::printf("render %.2f s on %u threads: %.3f M paths/s, %.3f M rays/s\n", r.render_s, r.threads,
                    paths_per_s * 1e-6, rays_per_s * 1e-6);
}

}  // namespace equistream::embree_host
