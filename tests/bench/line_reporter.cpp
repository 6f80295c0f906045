#include "line_reporter.h"

#include <cstdio>

namespace equistream::bench {

bool LineReporter::ReportContext(const Context& context) {
    std::fprintf(stderr, "# %d processors; medians of repeated, interleaved runs; ratio = peer's time / ours\n",
                 context.cpu_info.num_cpus);
    return true;
}

void LineReporter::ReportRuns(const std::vector<Run>& runs) {
    for (const Run& run : runs) {
        const std::string name = run.run_name.function_name;
        if (run.error_occurred) {
            if (left_out_.insert(name).second)
                std::fprintf(stderr, "# %s left out: %s\n", name.c_str(), run.error_message.c_str());
            continue;
        }
        if (!run.report_label.empty() && labels_.insert(name + run.report_label).second)
            std::fprintf(stderr, "# %s: %s\n", name.c_str(), run.report_label.c_str());
        if (run.run_type != Run::RT_Aggregate || run.aggregate_name != "median")
            continue;
        const std::size_t slash = name.rfind('/');
        const double ms = run.GetAdjustedRealTime() / benchmark::GetTimeUnitMultiplier(run.time_unit) * 1e3;
        Figure& figure = figures_[name.substr(0, slash)];
        const std::string side = name.substr(slash + 1);
        if (side == "ours")
            figure.ours_ms = ms;
        else
            figure.peers_ms[side] = ms;
    }
}

void LineReporter::Finalize() {
    for (const auto& [name, figure] : figures_) {
        if (figure.ours_ms && figure.peers_ms.empty())
            std::printf("%-28s %9.3f ms       - -\n", name.c_str(), *figure.ours_ms);
        for (const auto& [peer, peer_ms] : figure.peers_ms) {
            if (figure.ours_ms)
                std::printf("%-28s %9.3f ms %7.3f %s\n", name.c_str(), *figure.ours_ms, peer_ms / *figure.ours_ms,
                            peer.c_str());
            else
                std::printf("%-28s %9.3f ms       - -\n", (name + "/" + peer).c_str(), peer_ms);
        }
    }
}

}  // namespace equistream::bench
