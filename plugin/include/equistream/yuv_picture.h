#pragma once
/// A decoder's own planes, alive and unchanged for as long as anybody holds a copy of this.
#include <equistream/yuv.h>

#include <memory>

namespace equistream {

struct YuvPicture {
    YuvView planes;
    std::shared_ptr<const void> owner;

    bool empty() const { return planes.empty(); }
};

}  // namespace equistream
