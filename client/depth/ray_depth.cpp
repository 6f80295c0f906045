#include <equistream/error.h>
#include <equistream_client/ray_depth.h>
#include <equistream_scene/bvh.h>

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <array>
#include <limits>

namespace equistream {

namespace {

constexpr int packet_side = 4;  ///< a packet of 16 rays is a square: more coherent than a row

/// The rays of one 4x4 square; pixels outside the picture are switched off.
struct Packet {
    alignas(64) std::array<int, 16> valid{};
    RTCRayHit16 rays{};

    void start(int lane, const glm::dvec3& origin, const glm::dvec3& direction) {
        valid[lane] = -1;
        rays.ray.org_x[lane] = float(origin.x);
        rays.ray.org_y[lane] = float(origin.y);
        rays.ray.org_z[lane] = float(origin.z);
        rays.ray.dir_x[lane] = float(direction.x);
        rays.ray.dir_y[lane] = float(direction.y);
        rays.ray.dir_z[lane] = float(direction.z);
        rays.ray.tnear[lane] = 0;
        rays.ray.tfar[lane] = std::numeric_limits<float>::infinity();
        rays.ray.mask[lane] = ~0u;
        rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
};

template <typename AnyCamera>
void cast_square(const Bvh& bvh, const AnyCamera& camera, const Pose& pose, int x0, int y0, ImageView<float> depth_m) {
    Packet packet;
    for (int lane = 0; lane < 16; ++lane) {
        const int x = x0 + lane % packet_side;
        const int y = y0 + lane / packet_side;
        if (x < camera.width && y < camera.height)
            packet.start(lane, pose.position_m, pose.orientation * camera.direction(x + 0.5, y + 0.5));
    }
    bvh.intersect16(packet.valid.data(), packet.rays, true);
    for (int lane = 0; lane < 16; ++lane) {
        if (packet.valid[lane] == 0)
            continue;
        const bool hit = packet.rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
        depth_m.pixel(x0 + lane % packet_side, y0 + lane / packet_side)[0] =
            hit ? packet.rays.ray.tfar[lane] : std::numeric_limits<float>::infinity();
    }
}

template <typename AnyCamera>
void cast_picture(const Bvh& bvh, const AnyCamera& camera, const Pose& pose, ImageView<float> depth_m) {
    const int columns = (camera.width + packet_side - 1) / packet_side;
    const int rows = (camera.height + packet_side - 1) / packet_side;
    tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 4, 0, columns, 8), [&](const tbb::blocked_range2d<int>& r) {
        trace_thread_init();
        for (int row = r.rows().begin(); row < r.rows().end(); ++row)
            for (int column = r.cols().begin(); column < r.cols().end(); ++column)
                cast_square(bvh, camera, pose, column * packet_side, row * packet_side, depth_m);
    });
}

}  // namespace

struct RayDepth::State {
    SceneDescription scene;
    SceneModel model;
    std::vector<std::uint32_t> moving;
    Bvh bvh;

    explicit State(const SceneDescription& description)
        : scene(description), model(load_model(description.model, {.shading = false})),
          moving(find_moving_instances(model, scene)), bvh(model, {.moving_instances = moving}) {}
};

RayDepth::RayDepth(const SceneDescription& scene) : state_(std::make_unique<State>(scene)) {}

RayDepth::~RayDepth() = default;

void RayDepth::set_time(double time_s) {
    if (state_->moving.empty())
        return;
    const std::vector<glm::mat4> all = instance_transforms(state_->model, state_->scene, time_s);
    std::vector<glm::mat4> transforms;
    for (const std::uint32_t instance : state_->moving)
        transforms.push_back(all[instance]);
    state_->bvh.move(state_->moving, transforms);
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
