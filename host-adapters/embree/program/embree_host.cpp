#include "embree_host.h"
#include "frame_job.h"
#include "loaded_scene.h"

#include <host-adapters/common/host.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>

namespace equistream::embree_host {

using namespace render_command;

EmbreeHost::EmbreeHost() = default;
EmbreeHost::~EmbreeHost() = default;

HostText EmbreeHost::text() const {
    return {"embree", "Path traces a scene along a camera path into EXR sequences.",
            "equistream render pavilion.json --size 960x480 --frames 0-7 --layers --out frames",
            "Scene description (JSON)"};
}

void EmbreeHost::add_options(cli::CommandLine& app) {
    app.add_option("--max-bounces", path_options_.max_bounces, "Scatterings of a path at most")
        .between(0u, 250u)
        .with_default();
    app.add_flag("--unbiased", path_options_.unbiased,
                 "Leave out no light, and blur no reflections: noisier. Bias that remains: textures filtered to a "
                 "pixel's width, glass without thickness, --max-bounces");
}

const SceneDescription& EmbreeHost::describe(const RenderOptions& options) {
    description_ = load_scene(options.scene);
    return description_;
}

void EmbreeHost::load(const RenderOptions& options, const Timeline& timeline) {
    threads_ = options.threads;
    scene_ = std::make_unique<LoadedScene>(description_, path_options_, timeline.path, threads_);
    for (const std::string& note : scene_->model().notes)
        std::fprintf(stderr, "equistream render: %s\n", note.c_str());
}

HostRecord EmbreeHost::record() const {
    // The code is part of the name: frames of a renderer that has changed since are not resumed.
    return {std::string("equistream-embree ") + es_version() + ", code " + code_identity(),
            " bounces " + std::to_string(path_options_.max_bounces) + (path_options_.unbiased ? " unbiased" : "")};
}

HostNames EmbreeHost::names() const {
    HostNames names;
    for (const Object& object : scene_->model().objects)
        names.objects.push_back(object.name);
    for (const Material& material : scene_->model().materials)
        names.materials.push_back(material.name);
    return names;
}

void EmbreeHost::move_to(const FrameTimes& times) {
    scene_->move_to(times.now_s, times.previous_s, times.next_s);
}

void EmbreeHost::cast(std::span<const es_ray> rays, std::span<float> distances_m) {
    cast_rays(scene_->traced(), threads_, rays, distances_m);
}

void EmbreeHost::render(const FrameTask& task) {
    FrameJob job;
    job.frame = task.frame;
    job.wants_surfaces = task.stream->wants_geometry();
    job.wants_guides = task.stream->wants_guides();
    job.wants_ids = task.stream->wants_ids();
    job.scene = &scene_->traced();
    job.neighbours = scene_->neighbours();
    job.threads = threads_;
    job.stop = task.stop;
    job.paths_traced = task.paths_traced;
    counts_ += run_frame(job);
}

HostFigures EmbreeHost::figures(double render_s, nlohmann::json& json) const {
    const SceneModel& model = scene_->model();
    const double bvh_mib = static_cast<double>(scene_->bvh_bytes()) / (1 << 20);
    const std::uint64_t rays = counts_.path_rays + counts_.shadow_rays;
    const double rays_per_s = static_cast<double>(rays) / std::max(render_s, 1e-9);
    json["load_s"] = json["load_s"].get<double>() - scene_->bvh_s();
    json["bvh_s"] = scene_->bvh_s();
    json["bvh_mib"] = bvh_mib;
    json["triangles"] = model.triangle_count();
    json["unique_triangles"] = model.unique_triangle_count();
    json["path_rays"] = counts_.path_rays;
    json["shadow_rays"] = counts_.shadow_rays;
    json["texture_calls"] = counts_.texture_calls;
    const SkyOpenings& openings = scene_->openings();
    json["sky_openings"] = {{"cells", openings.cells()},
                            {"gain", openings.gain()},
                            {"mib", static_cast<double>(openings.memory_bytes()) / (1 << 20)},
                            {"learn_s", scene_->openings_s()}};
    json["cpu_s"] = {{"camera_rays", counts_.camera_rays_s},
                     {"path_rays", counts_.path_rays_s},
                     {"shadow_rays", counts_.shadow_rays_s},
                     {"shading_and_textures", counts_.shading_s},
                     {"film", counts_.film_s}};
    json["rays_per_s"] = rays_per_s;
    char loaded[160], rates[40];
    std::snprintf(loaded, sizeof loaded, "BVH %.2f s (%.0f MiB), %.2f M triangles (%.2f M unique)", scene_->bvh_s(),
                  bvh_mib, static_cast<double>(model.triangle_count()) * 1e-6,
                  static_cast<double>(model.unique_triangle_count()) * 1e-6);
    std::snprintf(rates, sizeof rates, "%.3f M rays/s", rays_per_s * 1e-6);
    return {loaded, rates, counts_.not_finite};
}

}  // namespace equistream::embree_host
