#include "frame_patches.h"

#include <equistream/error.h>
#include <equistream/sequence.h>

#include <tbb/global_control.h>

#include <limits>

namespace equistream::render_command {
namespace {

/// Rays cast at a time: enough for a vectorised host, few enough to hold.
constexpr int rays_at_a_time = 1 << 19;

/// Depth spheres from the host's rays.
class SphereCaster {
public:
    SphereCaster(RenderHost& host, const Pose& pose) : host_(host), pose_(pose) {}

    void cast(const glm::dvec3& offset_m, const EquirectCamera& camera, ImageView<float> depth_m) {
        const glm::vec3 origin(pose_.position_m + pose_.orientation * offset_m);
        const int rows = std::max(1, rays_at_a_time / camera.width);
        for (int y = 0; y < camera.height; y += rows) {
            const int count = std::min(rows, camera.height - y);
            make_rays(origin, camera, y, count);
            host_.cast(rays_, {depth_m.row(y), rays_.size()});
        }
    }

private:
    void make_rays(const glm::vec3& origin, const EquirectCamera& camera, int first_row, int row_count) {
        rays_.assign(static_cast<std::size_t>(row_count) * static_cast<std::size_t>(camera.width), es_ray{});
        const double columns = camera.range.longitude_span() / camera.width;
        es_ray* ray = rays_.data();
        for (int y = first_row; y < first_row + row_count; ++y)
            for (int x = 0; x < camera.width; ++x, ++ray) {
                const glm::vec3 d = glm::normalize(glm::vec3(pose_.orientation * camera.direction(x + 0.5, y + 0.5)));
                for (int axis = 0; axis < 3; ++axis) {
                    ray->origin[axis] = origin[axis];
                    ray->direction[axis] = d[axis];
                }
                ray->t_max = std::numeric_limits<float>::infinity();
                ray->footprint_rad = static_cast<float>(columns);
            }
    }

    RenderHost& host_;
    Pose pose_;
    std::vector<es_ray> rays_;
};

bool same_layout(const PatchAtlas& a, const PatchAtlas& b) {
    return a.sphere_width == b.sphere_width && a.sphere_height == b.sphere_height && a.block_side == b.block_side &&
           a.columns == b.columns && a.rows == b.rows && a.offsets_m == b.offsets_m;
}

}  // namespace

PatchSettings patch_settings(const RenderOptions& options, double head_radius_m) {
    PatchSettings settings;
    settings.sphere = {options.size.width, options.size.height, options.range};
    settings.box_radius_m = head_box_radius(static_cast<Eye>(options.eyes.front()), head_radius_m, options.ipd_m);
    settings.budget = options.patch_budget_percent / 100;
    settings.block_side =
        options.patch_side > 0 ? options.patch_side : smallest_patch_side(settings.sphere, settings.budget);
    if (!(settings.box_radius_m > 0))
        throw InputError(expected_found("--patches", "a head box: eyes apart (--ipd) or a head that leans",
                                        "eyes that stay at the sphere's centre"));
    return settings;
}

FramePatches::FramePatches(const RenderOptions& options, double head_radius_m)
    : options_(options), settings_(patch_settings(options, head_radius_m)) {}

std::optional<PatchAtlas> FramePatches::atlas_before(std::int64_t index) const {
    if (last_ && last_index_ == index - 1)
        return last_;
    const std::filesystem::path file = options_.out / "patches" / frame_file_name(index - 1);
    if (!std::filesystem::exists(file))
        return std::nullopt;
    const std::optional<PatchAtlas> before = read_exr_info(file).patches;
    return before && same_layout(*before, empty_atlas(settings_)) ? before : std::nullopt;
}

PatchPlan FramePatches::plan(RenderHost& host, const FrameTask& task) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, options_.threads);
    const Pose pose = camera_pose(settings_.sphere, task.head, static_cast<Eye>(task.stream->eye), options_.ipd_m,
                                  options_.lock == ES_LOCK_PATH ? AxisLock::path : AxisLock::world);
    SphereCaster caster(host, pose);
    const std::optional<PatchAtlas> before = atlas_before(task.index);
    PatchPlan plan = plan_patches(
        settings_,
        [&](const glm::dvec3& offset_m, const EquirectCamera& camera, ImageView<float> depth_m) {
            caster.cast(offset_m, camera, depth_m);
        },
        before ? &*before : nullptr);
    last_ = plan.atlas;
    last_index_ = task.index;
    return plan;
}

}  // namespace equistream::render_command
