#include "depth_source.h"

#include <client/warp/engine.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <utility>

namespace equistream {

ExactDepth::ExactDepth(std::unique_ptr<DepthSource> otherwise) : otherwise_(std::move(otherwise)) {}

void ExactDepth::set_time(double time_s) {
    planes_.clear();
    if (otherwise_)
        otherwise_->set_time(time_s);
}

void ExactDepth::add(const Camera& camera, const Pose& pose, ImageView<const float> depth_m) {
    assert(depth_m.width == width_of(camera) && depth_m.height == height_of(camera) && depth_m.channels == 1);
    planes_.push_back({camera, pose, depth_m});
}

const ExactDepth::Plane* ExactDepth::find(const Camera& camera, const Pose& pose) const {
    const auto plane = std::ranges::find_if(
        planes_, [&](const Plane& p) { return same_camera(p.camera, camera) && same_pose(p.pose, pose); });
    return plane == planes_.end() ? nullptr : &*plane;
}

void ExactDepth::cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) {
    const Plane* plane = find(camera, pose);
    if (plane == nullptr && !otherwise_)
        throw WorkError(expected_found("depth " + std::string(name()),
                                       name() == "stream" ? "a depth plane of every view in the stream"
                                                          : "a rendered depth plane of every view",
                                       "none of a " + size_text(width_of(camera), height_of(camera)) + " view"));
    if (plane == nullptr)
        return otherwise_->cast(camera, pose, depth_m);
    tbb::parallel_for(0, depth_m.height,
                      [&](int y) { std::copy_n(plane->depth_m.row(y), depth_m.width, depth_m.row(y)); });
}

bool ExactDepth::cast_patches(const PatchAtlas& atlas, const Pose& pose, ImageView<float> depth_m) {
    return otherwise_ && otherwise_->cast_patches(atlas, pose, depth_m);
}

}  // namespace equistream
