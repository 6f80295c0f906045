#pragma once
/// What find_images (mirror_kernels.h) computes, in double precision, one pixel after the other, through the public
/// cameras.
#include "../mirror_kernels.h"

namespace equistream {

void find_images_plainly(const MirrorJob& job, int y, MirrorRow& row);

}  // namespace equistream
