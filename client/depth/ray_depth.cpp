#include <equistream_client/ray_depth.h>

#include "ray_directions.h"
#include "sphere_history.h"

#include <equistream/bound.h>
#include <equistream_client/engine.h>
#include <equistream_scene/embree_rays.h>

#include <tbb/blocked_range.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

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
    void square(int x, int y, ImageView<float> depth_m) { square(x, y, depth_m, x, y); }
    /// The same, written to another place.
    void square(int x, int y, ImageView<float> depth_m, int to_x, int to_y) {
        directions_.square(x, y, out_);
        intersect();
        const int columns = std::min(packet_side, depth_m.width - to_x);
        const int rows = std::min(packet_side, depth_m.height - to_y);
        for (int j = 0; j < rows; ++j)
            std::copy_n(packet_.rays.ray.tfar + j * packet_side, columns, depth_m.pixel(to_x, to_y + j));
    }

    /// Any 16 pixels; those of less than 16 repeat.
    std::span<const float> pixels(const std::array<int, packet_size>& x, const std::array<int, packet_size>& y) {
        directions_.pixels(x, y, out_);
        intersect();
        return packet_.rays.ray.tfar;
    }

    /// Of the last packet's rays.
    std::int32_t plane(const SurfacePlanes& planes, std::size_t lane) const {
        return planes.of(bvh_.resolve(packet_.hit(lane)));
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

/// Pixels to cast, wherever they are, in packets of 16 that are near each other.
class PixelCaster {
public:
    PixelCaster(Caster& caster, SphereHistory& history, const SurfacePlanes& planes, ImageView<float> depth_m)
        : caster_(caster), history_(history), planes_(planes), depth_m_(depth_m) {}
    ~PixelCaster() { flush(); }
    PixelCaster(const PixelCaster&) = delete;
    PixelCaster& operator=(const PixelCaster&) = delete;

    void add(int x, int y) {
        x_[std::size_t(count_)] = x;
        y_[std::size_t(count_)] = y;
        if (++count_ == packet_size)
            flush();
    }

    /// All of a square at once.
    void square(int x, int y) {
        caster_.square(x, y, depth_m_);
        for (int j = y; j < std::min(y + packet_side, depth_m_.height); ++j)
            for (int i = x; i < std::min(x + packet_side, depth_m_.width); ++i)
                history_.set_cast(i, j, caster_.plane(planes_, std::size_t((j - y) * packet_side + i - x)));
    }

private:
    void flush() {
        if (count_ == 0)
            return;
        for (auto i = std::size_t(count_); i < packet_size; ++i) {
            x_[i] = x_[0];
            y_[i] = y_[0];
        }
        const std::span<const float> distance_m = caster_.pixels(x_, y_);
        for (std::size_t i = 0; i < std::size_t(count_); ++i) {
            depth_m_.pixel(x_[i], y_[i])[0] = distance_m[i];
            history_.set_cast(x_[i], y_[i], caster_.plane(planes_, i));
        }
        count_ = 0;
    }

    Caster& caster_;
    SphereHistory& history_;
    const SurfacePlanes& planes_;
    ImageView<float> depth_m_;
    std::array<int, packet_size> x_{}, y_{};
    int count_ = 0;
};

constexpr int most_histories = 4;        ///< two eyes' spheres, now and before
constexpr unsigned refresh_frames = 64;  ///< every square is cast at least once in so many frames

/// Squares are cast anew in turn, scattered over the picture.
bool is_refreshed(int column, int row, unsigned frame) {
    return (unsigned(column) * 7 + unsigned(row) * 19 + frame) % refresh_frames == 0;
}

bool same_rotation(const Pose& a, const Pose& b) {
    return a.orientation == b.orientation;
}

}  // namespace

struct RayDepth::State {
    SceneDescription scene;
    RayDepthOptions options;
    SceneModel model;
    std::vector<std::uint32_t> movers;
    Bvh bvh;
    std::optional<SurfacePlanes> planes;                    ///< where frames are reused
    std::vector<MoverBall> mover_balls;                     ///< now
    std::vector<std::unique_ptr<SphereHistory>> histories;  ///< the oldest first
    std::vector<std::unique_ptr<SphereHistory>> spare;      ///< what was taken back, for its memory
    CastMask cast;                                          ///< of the frame at hand
    unsigned frame = 0;
    std::size_t histories_before = 0;  ///< those of `histories` that were there when the time was set
    unsigned frame_before = 0;

    State(const SceneDescription& description, const RayDepthOptions& ray_options)
        : scene(description), options(ray_options), model(load_model(description, {.shading = false})),
          movers(find_moving_instances(model, scene)), bvh(model, {.moving_instances = movers}) {
        if (options.reuse)
            planes.emplace(model, movers);
    }

    ReuseBound bound() const {
        const double box_m =
            options.box_radius_m > 0 ? options.box_radius_m : head_box_radius_centre(scene.lean_m, default_ipd_m);
        return {box_m, options.error_rad};
    }

    void begin_frame() {
        histories_before = histories.size();
        frame_before = frame;
    }
    void take_back() {
        while (histories.size() > histories_before) {
            spare.push_back(std::move(histories.back()));
            histories.pop_back();
        }
        frame = frame_before;
    }

    void set_balls(const std::vector<glm::mat4>& transforms) {
        mover_balls.clear();
        for (const std::uint32_t i : movers) {
            const Mesh& mesh = model.meshes[model.instances[i].mesh];
            glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
            for (const glm::vec3& p : mesh.positions) {
                const glm::dvec3 at(transforms[i] * glm::vec4(p, 1));
                low = glm::min(low, at);
                high = glm::max(high, at);
            }
            mover_balls.push_back({0.5 * (low + high), 0.5 * glm::distance(low, high)});
        }
    }

    /// The nearest one that can be carried to the pose; null if there is none.
    const SphereHistory* nearest(const EquirectCamera& camera, const Pose& pose) const {
        const SphereHistory* best = nullptr;
        const auto way = [&](const SphereHistory& h) { return glm::distance(h.pose().position_m, pose.position_m); };
        for (const auto& history : histories)
            if (same_camera(history->camera(), camera) && same_rotation(history->pose(), pose) &&
                (best == nullptr || way(*history) <= way(*best)))
                best = history.get();
        return best;
    }

    void cast_sphere(const EquirectCamera& camera, const Pose& pose, ImageView<float> depth_m) {
        const SphereHistory* last = nearest(camera, pose);
        std::unique_ptr<SphereHistory> next = take_history(camera, last);
        cast.resize(camera.width, camera.height);
        const bool carried = last != nullptr && next->carry(*last, pose, mover_balls, cast, depth_m);
        if (!carried)
            cast.set_all(1);
        ++frame;
        cast_marked(camera, pose, *next, depth_m);
        if (carried)
            next->fill_poles(cast, depth_m);
        next->finish(pose, mover_balls, depth_m);
        histories.push_back(std::move(next));
    }

    /// The memory of one that is not needed any more, or of the oldest, if there are enough of them.
    std::unique_ptr<SphereHistory> take_history(const EquirectCamera& camera, const SphereHistory* in_use) {
        std::unique_ptr<SphereHistory> taken;
        if (!spare.empty()) {
            taken = std::move(spare.back());
            spare.pop_back();
        } else if (histories.size() < most_histories) {
            return std::make_unique<SphereHistory>(camera, bound(), *planes);
        } else {
            const auto oldest = histories.front().get() == in_use ? histories.begin() + 1 : histories.begin();
            if (std::size_t(oldest - histories.begin()) < histories_before)
                --histories_before;
            taken = std::move(*oldest);
            histories.erase(oldest);
        }
        if (!same_camera(taken->camera(), camera))
            taken = std::make_unique<SphereHistory>(camera, bound(), *planes);
        return taken;
    }

    void cast_marked(const EquirectCamera& camera, const Pose& pose, SphereHistory& next, ImageView<float> depth_m) {
        const RayDirections directions(camera, pose.orientation);
        const int columns = (camera.width + packet_side - 1) / packet_side;
        const int rows = (camera.height + packet_side - 1) / packet_side;
        tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 4, 0, columns, 16), [&](const auto& r) {
            trace_thread_init();
            Caster caster(bvh, directions, pose.position_m);
            PixelCaster pixels(caster, next, *planes, depth_m);
            for (int row = r.rows().begin(); row < r.rows().end(); ++row)
                for (int column = r.cols().begin(); column < r.cols().end(); ++column) {
                    const int x = column * packet_side, y = row * packet_side;
                    const unsigned marked = cast.square(x, y);
                    if (marked == 0xffff || is_refreshed(column, row, frame)) {
                        pixels.square(x, y);
                        continue;
                    }
                    for (unsigned left = marked; left != 0; left &= left - 1) {
                        const int bit = std::countr_zero(left);
                        pixels.add(x + bit % packet_side, y + bit / packet_side);
                    }
                }
        });
    }
};

RayDepth::RayDepth(const SceneDescription& scene, const RayDepthOptions& options)
    : state_(std::make_unique<State>(scene, options)) {
    set_time(0);
}

RayDepth::~RayDepth() = default;

void RayDepth::set_time(double time_s) {
    state_->begin_frame();
    if (state_->movers.empty())
        return;
    const std::vector<glm::mat4> transforms = instance_transforms(state_->model, state_->scene, time_s);
    state_->bvh.move(transforms);
    state_->set_balls(transforms);
}

void RayDepth::cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) {
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    if (sphere != nullptr && state_->options.reuse)
        return state_->cast_sphere(*sphere, pose, depth_m);
    cast_picture(state_->bvh, camera, pose, depth_m);
}

bool RayDepth::cast_patches(const PatchAtlas& atlas, const Pose& pose, ImageView<float> depth_m) {
    cast_atlas(state_->bvh, atlas, pose, depth_m);
    return true;
}

void RayDepth::take_back() {
    state_->take_back();
}

void RayDepth::forget() {
    state_->histories_before = 0;
    state_->frame_before = 0;
    state_->take_back();
}

std::uint64_t RayDepth::triangle_count() const {
    return state_->model.triangle_count();
}

std::size_t RayDepth::memory_bytes() const {
    return state_->bvh.memory_bytes();
}

}  // namespace equistream
