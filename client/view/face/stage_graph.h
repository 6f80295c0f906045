#pragma once
/// Refreshes' times, told apart by stage: the last ones as a graph, and the newest in figures. By Dear ImGui.
#include <client/view/gl/eye_renderer.h>

#include <cstddef>
#include <string>
#include <vector>

namespace equistream {

class StageGraph {
public:
    void add(const gl::StageTimes::Row& row, double refresh_ms);
    bool is_empty() const { return rows_.empty(); }
    /// In the upper right corner of what lies below `top`, left of `right`.
    void build(float top, float right, const std::string& decoder) const;

private:
    static constexpr std::size_t max_rows = 180;

    std::vector<gl::StageTimes::Row> rows_;  ///< a ring
    std::vector<double> refreshes_ms_;
    std::size_t newest_ = 0;
};

}  // namespace equistream
