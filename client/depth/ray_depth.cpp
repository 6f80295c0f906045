#include "ray_depth.h"

#include <scenes/embree/embree_rays.h>

#include <tbb/blocked_range.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace equistream {

namespace {

/// Squares reach up to this many pixels beyond the picture.
constexpr int margin = packet_side - 1;

}  // namespace

RayDirections::RayDirections(const Camera& camera, const glm::dquat& orientation)
    : equirect_(std::holds_alternative<EquirectCamera>(camera)) {
    const int width = width_of(camera), height = height_of(camera);
    for (auto [vectors, length] : {std::pair{&column_, width}, {&row_, height}})
        for (std::vector<float>* list : {&vectors->x, &vectors->y, &vectors->z})
            list->resize(std::size_t(length + margin));
    row_cos_.resize(std::size_t(height + margin), 1.0f);
    const glm::dmat3 axes = glm::mat3_cast(orientation);
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    for (int i = 0; i < width + margin; ++i) {
        const double u = std::min(i, width - 1) + 0.5;
        if (sphere != nullptr) {
            const double longitude = sphere->range.longitude_min + u * sphere->range.longitude_span() / width;
            const auto d = direction_from_longitude_latitude(longitude, 0.0);
            set(column_, std::size_t(i), axes * glm::dvec3(d.x, d.y, d.z));
        } else {
            const auto& view = std::get<PerspectiveCamera>(camera);
            set(column_, std::size_t(i), axes * glm::dvec3((u - 0.5 * width) / view.focal_px(), 0, -1));
        }
    }
    for (int i = 0; i < height + margin; ++i) {
        const double v = std::min(i, height - 1) + 0.5;
        if (sphere != nullptr) {
            const double latitude = sphere->range.latitude_max - v * sphere->range.latitude_span() / height;
            set(row_, std::size_t(i), axes * glm::dvec3(0, std::sin(latitude), 0));
            row_cos_[std::size_t(i)] = float(std::cos(latitude));
        } else {
            const auto& view = std::get<PerspectiveCamera>(camera);
            set(row_, std::size_t(i), axes * glm::dvec3(0, (0.5 * height - v) / view.focal_px(), 0));
        }
    }
}

void RayDirections::set(Vectors& vectors, std::size_t i, const glm::dvec3& v) const {
    vectors.x[i] = float(v.x);
    vectors.y[i] = float(v.y);
    vectors.z[i] = float(v.z);
}

void RayDirections::write(int lane, int x, int y, DirectionPacket& out) const {
    const auto column = std::size_t(x), row = std::size_t(y);
    const float c = row_cos_[row];
    out.x[lane] = c * column_.x[column] + row_.x[row];
    out.y[lane] = c * column_.y[column] + row_.y[row];
    out.z[lane] = c * column_.z[column] + row_.z[row];
}

namespace {

void normalise(DirectionPacket& out) {
    for (int lane = 0; lane < packet_size; ++lane) {
        const float scale =
            1.0f / std::sqrt(out.x[lane] * out.x[lane] + out.y[lane] * out.y[lane] + out.z[lane] * out.z[lane]);
        out.x[lane] *= scale;
        out.y[lane] *= scale;
        out.z[lane] *= scale;
    }
}

}  // namespace

void RayDirections::square(int x, int y, DirectionPacket& out) const {
    for (int j = 0; j < packet_side; ++j)
        for (int i = 0; i < packet_side; ++i)
            write(j * packet_side + i, x + i, y + j, out);
    if (!equirect_)
        normalise(out);
}

namespace {

/// A packet whose rays all start at one point; only what Embree changes is set again for the next 16.
class Caster {
public:
    Caster(const Bvh& bvh, const RayDirections& directions, const glm::dvec3& origin)
        : bvh_(bvh), directions_(directions) {
        for (std::size_t lane = 0; lane < packet_size; ++lane)
            packet_.start(lane, glm::vec3(origin), glm::vec3(0));
    }

    /// The square whose first pixel is given, to one that begins at (to_x, to_y); what lies outside the picture is left
    /// out.
    void square(int x, int y, ImageView<float> depth_m, int to_x, int to_y) {
        directions_.square(x, y, out_);
        intersect();
        const int columns = std::min(packet_side, depth_m.width - to_x);
        const int rows = std::min(packet_side, depth_m.height - to_y);
        for (int j = 0; j < rows; ++j)
            std::copy_n(packet_.rays.ray.tfar + j * packet_side, columns, depth_m.pixel(to_x, to_y + j));
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
                caster.square(column * packet_side, row * packet_side, depth_m, column * packet_side,
                              row * packet_side);
    });
}

/// The sphere's grid, extended to whole blocks as patches are.
EquirectCamera whole_blocks(const PatchAtlas& atlas) {
    EquirectCamera camera = atlas.sphere();
    const double longitude_step = camera.range.longitude_span() / camera.width;
    const double latitude_step = camera.range.latitude_span() / camera.height;
    camera.width = atlas.block_columns() * atlas.block_side;
    camera.height = atlas.block_rows() * atlas.block_side;
    camera.range.longitude_max = camera.range.longitude_min + camera.width * longitude_step;
    camera.range.latitude_min = camera.range.latitude_max - camera.height * latitude_step;
    return camera;
}

void cast_slot(Caster& caster, const PatchAtlas& atlas, const PatchAtlas::Slot& slot, ImageView<float> slot_depth_m) {
    const int side = atlas.block_side;
    for (int y = 0; y < side; y += packet_side)
        for (int x = 0; x < side; x += packet_side)
            caster.square(slot.block_x * side + x, slot.block_y * side + y, slot_depth_m, x, y);
}

void cast_atlas(const Bvh& bvh, const PatchAtlas& atlas, const Pose& pose, ImageView<float> depth_m) {
    const RayDirections directions(whole_blocks(atlas), pose.orientation);
    const int side = atlas.block_side;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, atlas.slots.size(), 64), [&](const auto& slots) {
        trace_thread_init();
        for (std::size_t i = slots.begin(); i < slots.end(); ++i) {
            const PatchAtlas::Slot& slot = atlas.slots[i];
            const int x = int(i) % atlas.columns * side, y = int(i) / atlas.columns * side;
            const ImageView<float> slot_depth_m{depth_m.pixel(x, y), side, side, 1, depth_m.row_stride};
            if (slot.used) {
                const glm::dvec3 offset_m = pose.orientation * atlas.offsets_m[slot.offset_index];
                Caster caster(bvh, directions, pose.position_m + offset_m);
                cast_slot(caster, atlas, slot, slot_depth_m);
            } else {
                for (int row = 0; row < side; ++row)
                    std::fill_n(slot_depth_m.row(row), side, std::numeric_limits<float>::infinity());
            }
        }
    });
}

}  // namespace

struct RayDepth::State {
    SceneDescription scene;
    SceneModel model;
    std::vector<std::uint32_t> movers;
    Bvh bvh;

    explicit State(const SceneDescription& description)
        : scene(description), model(load_model(description, {.shading = false})),
          movers(find_moving_instances(model, scene)), bvh(model, {.moving_instances = movers}) {}
};

RayDepth::RayDepth(const SceneDescription& scene) : state_(std::make_unique<State>(scene)) {
    set_time(0);
}

RayDepth::~RayDepth() = default;

void RayDepth::set_time(double time_s) {
    if (!state_->movers.empty())
        state_->bvh.move(instance_transforms(state_->model, state_->scene, time_s));
}

void RayDepth::cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) {
    cast_picture(state_->bvh, camera, pose, depth_m);
}

bool RayDepth::cast_patches(const PatchAtlas& atlas, const Pose& pose, ImageView<float> depth_m) {
    cast_atlas(state_->bvh, atlas, pose, depth_m);
    return true;
}

}  // namespace equistream
