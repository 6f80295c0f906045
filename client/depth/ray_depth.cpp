#include <equistream_client/ray_depth.h>

#include "ray_directions.h"

#include <equistream/error.h>
#include <equistream_scene/embree_rays.h>

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace equistream {

namespace {

/// A packet whose rays all start at one point; only what Embree changes is set again for the next 16.
class Caster {
public:
    Caster(const Bvh& bvh, const RayDirections& directions, const glm::dvec3& origin)
        : bvh_(bvh), directions_(directions) {
        for (std::size_t lane = 0; lane < packet_size; ++lane)
            packet_.start(lane, glm::vec3(origin), glm::vec3(0));
    }

    /// The square whose first pixel is given; what lies outside the picture is left out.
    void square(int x, int y, ImageView<float> depth_m) {
        directions_.square(x, y, out_);
        intersect();
        const int columns = std::min(packet_side, depth_m.width - x), rows = std::min(packet_side, depth_m.height - y);
        for (int j = 0; j < rows; ++j)
            std::copy_n(packet_.rays.ray.tfar + j * packet_side, columns, depth_m.pixel(x, y + j));
    }

private:
    void intersect() {
        RTCRayHit16& rays = packet_.rays;
        for (std::size_t lane = 0; lane < packet_size; ++lane) {
            rays.ray.dir_x[lane] = out_.x[lane];
            rays.ray.dir_y[lane] = out_.y[lane];
            rays.ray.dir_z[lane] = out_.z[lane];
            rays.ray.tfar[lane] = std::numeric_limits<float>::infinity();
            rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
            rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
        }
        bvh_.intersect16(packet_.valid.data(), rays, true);
    }

    const Bvh& bvh_;
    const RayDirections& directions_;
    RayPacket packet_;
    DirectionPacket out_;
};

void cast_picture(const Bvh& bvh, const Camera& camera, const Pose& pose, ImageView<float> depth_m) {
    const RayDirections directions(camera, pose.orientation);
    const int columns = (depth_m.width + packet_side - 1) / packet_side;
    const int rows = (depth_m.height + packet_side - 1) / packet_side;
    tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 4, 0, columns, 8), [&](const tbb::blocked_range2d<int>& r) {
        trace_thread_init();
        Caster caster(bvh, directions, pose.position_m);
        for (int row = r.rows().begin(); row < r.rows().end(); ++row)
            for (int column = r.cols().begin(); column < r.cols().end(); ++column)
                caster.square(column * packet_side, row * packet_side, depth_m);
    });
}

}  // namespace

struct RayDepth::State {
    SceneDescription scene;
    SceneModel model;
    Bvh bvh;

    explicit State(const SceneDescription& description)
        : scene(description), model(load_model(description, {.shading = false})),
          bvh(model, {.moving_instances = find_moving_instances(model, scene)}) {}
};

RayDepth::RayDepth(const SceneDescription& scene) : state_(std::make_unique<State>(scene)) {}

RayDepth::~RayDepth() = default;

void RayDepth::set_time(double time_s) {
    if (!state_->scene.moving.empty())
        state_->bvh.move(instance_transforms(state_->model, state_->scene, time_s));
}

void RayDepth::cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) {
    cast_picture(state_->bvh, camera, pose, depth_m);
}

std::uint64_t RayDepth::triangle_count() const {
    return state_->model.triangle_count();
}

std::size_t RayDepth::memory_bytes() const {
    return state_->bvh.memory_bytes();
}

}  // namespace equistream
