#pragma once
/// What a refresh's time went into. GPUs work behind the caller's back: stages are told apart only where the pipeline
/// is drained between them, which costs a little and is done while somebody looks at the figures.
#include <equistream/elapsed.h>

#include <array>
#include <cstddef>
#include <string_view>

namespace equistream::gl {

enum class RenderStage { upload, depth, carry, reproject, fill, judge, display };
inline constexpr std::array<std::string_view, 7> render_stage_names = {"upload", "depth",       "carry",  "reproject",
                                                                       "fill",   "reliability", "display"};

class StageTimes {
public:
    /// Of one refresh, in milliseconds.
    using Row = std::array<double, render_stage_names.size()>;

    void start(bool told_apart);
    /// What passed since the last mark was that stage's.
    void mark(RenderStage stage);

    const Row& row() const { return row_; }

private:
    bool told_apart_ = false;
    Clock::time_point last_;
    Row row_{};
};

}  // namespace equistream::gl
