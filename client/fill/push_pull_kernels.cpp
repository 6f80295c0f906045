#include "push_pull.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/fill/push_pull_kernels.cpp"
// The scalar loops too, whatever the processor has; as in warp_kernels.cpp, nothing here takes high halves of products.
#define HWY_COMPILE_ALL_ATTAINABLE
#define HWY_BROKEN_EMU128 0
#include <hwy/foreach_target.h>

#include "push_pull_pull-inl.h"
#include "push_pull_push-inl.h"

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(pull_tiles_here);
HWY_EXPORT(pull_upper_level_here);
HWY_EXPORT(push_upper_level_here);
HWY_EXPORT(push_tiles_here);
HWY_EXPORT(colour_spans_here);

void pull_tiles(PullPyramid& pyramid, std::size_t first, std::size_t last) {
    HWY_DYNAMIC_DISPATCH(pull_tiles_here)(pyramid, first, last);
}
void pull_upper_level(PullPyramid& pyramid, int level) {
    HWY_DYNAMIC_DISPATCH(pull_upper_level_here)(pyramid, level);
}
void push_upper_level(PullPyramid& pyramid, int level) {
    HWY_DYNAMIC_DISPATCH(push_upper_level_here)(pyramid, level);
}
void push_tiles(PullPyramid& pyramid, int level, std::size_t first, std::size_t last) {
    HWY_DYNAMIC_DISPATCH(push_tiles_here)(pyramid, level, first, last);
}
std::int64_t colour_spans(const PullPyramid& pyramid, std::span<const GapSpan> spans) {
    return HWY_DYNAMIC_DISPATCH(colour_spans_here)(pyramid, spans);
}

}  // namespace equistream
#endif
