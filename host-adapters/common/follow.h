#pragma once
/// `equistream render --follow`: single frames, each when and where it is asked for, of a scene that stays loaded.
///
/// Standard input has an order a line, standard output an answer a line, both JSON. First of all comes
///     {"frames_per_second": 30}
/// then for each order, before which there is no other,
///     {"frame": 17, "spp": 4, "position_m": [x, y, z], "orientation_wxyz": [w, x, y, z]}
/// at what time (frame / frames_per_second) and from where the head is (left out: where the path has it then); with
/// "gaze": [x, y, z] a window lies around that direction in the world, else straight ahead of the head; with
/// "base_spp": 2 the sphere around it has so many samples, else as many as the window; with "window_halvings": 1 the
/// window's pixels are halved so many times (window_grids; at most the most there are). The answer, once its file is
/// whole:
///     {"frame": 17, "file": "DIR/spp-4/centre/frame.0017.exr", "render_s": 0.21, "write_s": 0.01}
/// ("DIR/centre/..." with --accumulate). With --window there is also "window", its file: in DIR/spp-4, or in DIR where
/// it stays and is accumulated; with halved pixels in DIR/halved-1 and so on. Backward motion leads to the frame that
/// was asked for before, wherever it was. Frames ascend. The asker removes the files. It ends where standard input
/// does, in the middle of a frame too.
#include "stream.h"

#include <atomic>
#include <cstddef>
#include <optional>
#include <string>

namespace equistream::render_command {

/// Borrowed until follow() returns.
struct FollowJob {
    const RenderOptions& options;
    const SceneDescription& scene;
    const Timeline& timeline;
    const RenderRecord& record;
    const std::atomic<bool>& interrupted;
};

/// Throws InputError for options that it cannot do, WorkError for what is no order.
void follow(const FollowJob& job, RenderHost& host);

// Lines of a file descriptor on which another process writes when it likes.

class LineInput {
public:
    /// `interrupted` is borrowed; waiting ends soon after it is set.
    LineInput(int descriptor, const std::atomic<bool>& interrupted)
        : descriptor_(descriptor), interrupted_(interrupted) {}

    /// The next line without its end, waited for; nothing where they have ended, or at an interrupt. Throws WorkError
    /// for one that is longer than any order.
    std::optional<std::string> next();
    /// Whether nobody writes any more, or there was an interrupt. Any thread may ask.
    bool has_ended() const;

private:
    static constexpr std::size_t longest_line = 4096;

    int descriptor_;
    const std::atomic<bool>& interrupted_;
    std::string read_;  // beyond the last line given
};

}  // namespace equistream::render_command
