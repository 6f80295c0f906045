#include "report.h"

#include <equistream/json_text.h>
#include <programs/cli/provenance.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

namespace equistream::render_command {
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

void print_report(const RenderReport& r, const RenderHost& host, const std::string& command, bool json) {
    const double paths_per_s = static_cast<double>(r.paths) / std::max(r.render_s, 1e-9);
    const double peak_mib = peak_memory_mib();
    nlohmann::json report = {{"frames_rendered", r.frames_rendered},
                             {"frames_kept", r.frames_kept},
                             {"threads", r.threads},
                             {"load_s", r.load_s},
                             {"render_s", r.render_s},
                             {"peak_memory_mib", peak_mib},
                             {"paths", r.paths},
                             {"paths_per_s", paths_per_s}};
    const PatchReport& patches = r.patches;
    const auto frames = static_cast<double>(std::max<std::int64_t>(patches.frames, 1));
    if (patches.frames > 0)
        report["patches"] = {{"frames", patches.frames},
                             {"pixel_share", patches.pixel_share / frames},
                             {"covered_of_training", patches.covered / frames},
                             {"kept_slots", patches.kept_slots / std::max(patches.used_slots, 1.0)},
                             {"plan_s", patches.plan_s}};
    const HostFigures figures = host.figures(r.render_s, report);
    report["left_out_samples"] = figures.left_out_samples;
    report.update(cli::provenance(command));
    if (json) {
        std::printf("%s\n", json_text(report, 2).c_str());
        return;
    }
    std::printf("%lld frames rendered, %lld kept\n", static_cast<long long>(r.frames_rendered),
                static_cast<long long>(r.frames_kept));
    std::printf("load %.2f s, %s, peak memory %.0f MiB\n", report["load_s"].get<double>(), figures.loaded.c_str(),
                peak_mib);
    if (figures.left_out_samples > 0)
        std::printf("%llu samples were not finite and are left out\n",
                    static_cast<unsigned long long>(figures.left_out_samples));
    if (r.frames_rendered > 0)
        std::printf("render %.2f s on %u threads: %.3f M paths/s%s%s\n", r.render_s, r.threads, paths_per_s * 1e-6,
                    figures.rates.empty() ? "" : ", ", figures.rates.c_str());
    if (patches.frames > 0)
        std::printf("patches show %.1f %% of what eyes uncover in %.1f %% of the sphere's pixels; %.0f %% of the slots "
                    "stayed; planned in %.2f s a frame, %.1f %% of the time\n",
                    100 * patches.covered / frames, 100 * patches.pixel_share / frames,
                    100 * patches.kept_slots / std::max(patches.used_slots, 1.0), patches.plan_s / frames,
                    100 * patches.plan_s / std::max(r.render_s, 1e-9));
}

}  // namespace equistream::render_command
