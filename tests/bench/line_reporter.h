#pragma once
/// Prints one line a figure: `name value unit ratio peer`, the ratio being peer's time over ours (above 1: we are
/// faster).
#include <benchmark/benchmark.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace equistream::bench {

/// Takes google-benchmark's medians of runs named FIGURE/ours and FIGURE/PEER. A figure without a peer has "-" for
/// both; a peer without ours is a line of its own, named FIGURE/PEER.
class LineReporter : public benchmark::BenchmarkReporter {
public:
    bool ReportContext(const Context& context) override;
    void ReportRuns(const std::vector<Run>& runs) override;
    void Finalize() override;

private:
    struct Figure {
        std::optional<double> ours_ms;  ///< none where a filter left it out
        std::map<std::string, double> peers_ms;
    };
    std::map<std::string, Figure> figures_;
    std::set<std::string> left_out_, labels_;  ///< told already: every repetition says so again
};

}  // namespace equistream::bench
