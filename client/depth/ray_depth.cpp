#include <equistream/error.h>
#include <equistream_client/ray_depth.h>
#include <equistream_scene/embree_rays.h>

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

namespace equistream {

namespace {

constexpr int packet_side = 4;  ///< a packet of 16 rays is a square: more coherent than a row

/// The square whose first pixel is `corner`; what lies outside the picture is left out.
template <typename AnyCamera>
void cast_square(const Bvh& bvh, const AnyCamera& camera, const Pose& pose, glm::ivec2 corner,
                 ImageView<float> depth_m) {
    RayPacket packet;
    const auto pixel = [&](int lane) { return corner + glm::ivec2(lane % packet_side, lane / packet_side); };
    for (int lane = 0; lane < 16; ++lane) {
        const glm::ivec2 at = pixel(lane);
        if (at.x < camera.width && at.y < camera.height)
            packet.start(std::size_t(lane), glm::vec3(pose.position_m),
                         glm::vec3(pose.orientation * camera.direction(at.x + 0.5, at.y + 0.5)));
    }
    bvh.intersect16(packet.valid.data(), packet.rays, true);
    for (int lane = 0; lane < 16; ++lane)
        if (packet.started(std::size_t(lane)))
            depth_m.pixel(pixel(lane).x, pixel(lane).y)[0] = packet.distance(std::size_t(lane));
}

template <typename AnyCamera>
void cast_picture(const Bvh& bvh, const AnyCamera& camera, const Pose& pose, ImageView<float> depth_m) {
    const int columns = (camera.width + packet_side - 1) / packet_side;
    const int rows = (camera.height + packet_side - 1) / packet_side;
    tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 4, 0, columns, 8), [&](const tbb::blocked_range2d<int>& r) {
        trace_thread_init();
        for (int row = r.rows().begin(); row < r.rows().end(); ++row)
            for (int column = r.cols().begin(); column < r.cols().end(); ++column)
                cast_square(bvh, camera, pose, glm::ivec2(column, row) * packet_side, depth_m);
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
    std::visit([&](const auto& c) { cast_picture(state_->bvh, c, pose, depth_m); }, camera);
}

std::uint64_t RayDepth::triangle_count() const {
    return state_->model.triangle_count();
}

std::size_t RayDepth::memory_bytes() const {
    return state_->bvh.memory_bytes();
}

}  // namespace equistream
