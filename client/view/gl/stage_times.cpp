#include "stage_times.h"

#include <epoxy/gl.h>

namespace equistream::gl {

void StageTimes::start(bool told_apart) {
    told_apart_ = told_apart;
    row_ = {};
    if (told_apart_)
        glFinish();
    last_ = Clock::now();
}

void StageTimes::mark(RenderStage stage) {
    if (!told_apart_)
        return;
    glFinish();
    row_[std::size_t(stage)] += milliseconds_since(last_);
    last_ = Clock::now();
}

}  // namespace equistream::gl
