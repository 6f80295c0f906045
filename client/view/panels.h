#pragma once
/// What is written over the picture: keys, frame times by stage, and a line on where in time and space the viewer is.
/// By Dear ImGui, in the context in which it is made.
#include <client/view/gl/eye_renderer.h>

#include <client/gpu/objects.h>

#include <cstddef>
#include <string>
#include <vector>

namespace equistream {

/// The line at the bottom.
struct StatusLine {
    std::string text;
    double fraction_done = 0;  ///< of the source, 0 to 1
    std::string warning;       ///< above it; empty: none
    std::string decoder;       ///< of the frame; shown with the times; empty: it was not coded
    std::string legend;        ///< of an overlay whose colours are shown beside it (MotionLegend); empty: none

    bool operator==(const StatusLine&) const = default;
};

/// How many pixels of the window a pixel of the letters is wide: a whole number, so that no letter loses a stroke. What
/// does not fit into the window goes to another page.
int text_scale(gl::Size window);

class Panels {
public:
    Panels();
    ~Panels();
    Panels(const Panels&) = delete;
    Panels& operator=(const Panels&) = delete;

    /// One refresh's times, told apart by stage; `refresh_ms` from the one before to it.
    void add(const gl::StageTimes::Row& row, double refresh_ms);

    /// The keys' first page, the next, or after the last none.
    void turn_help_page() { ++help_page_; }

    void draw(const StatusLine& status, gl::Size window, bool with_times);

private:
    void build(const StatusLine& status, bool with_times);
    void build_help(float room);
    void build_times(const std::string& decoder) const;

    static constexpr std::size_t max_rows = 180;

    std::vector<gl::StageTimes::Row> rows_;  ///< a ring
    std::vector<double> refreshes_ms_;
    std::size_t newest_ = 0;
    int help_page_ = 0;  ///< from 1; 0: none
};

}  // namespace equistream
