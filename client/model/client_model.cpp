#include "client_model.h"

#include "model_draft.h"

#include <equistream/bound.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <scenes/library/write_glb.h>

#include <fcntl.h>
#include <stb/stb_image_write.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace equistream {

namespace {

/// The rays that a restoring learns from are others than those that judge it.
constexpr std::uint64_t seed_step = 1000003;

void require_options(const ClientModelOptions& options, const SceneDescription& scene) {
    if (!(options.error_rad > 0) || !std::isfinite(options.error_rad))
        throw InputError(
            expected_found("geometry's error", "an angle above 0", formatted("%g rad", options.error_rad)));
    if (!(options.silhouette_rad >= options.error_rad))
        throw InputError(
            expected_found("shift of edges", "at least geometry's error", formatted("%g rad", options.silhouette_rad)));
    if (!(options.ipd_m >= 0) || !std::isfinite(options.ipd_m))
        throw InputError(expected_found("inter-pupillary distance", "0 m or more", formatted("%g m", options.ipd_m)));
    if (scene.camera_path.empty())
        throw InputError(expected_found(scene.file.string(), "a camera path", "none"));
    if (!(head_box_radius_centre(scene.head_radius_m, options.ipd_m) > 0))
        throw InputError(
            expected_found(scene.file.string(), "a head box: head_box.lean_m or --ipd above 0", "neither"));
}

/// What a mover hides now it will not hide later.
SeenTriangles find_seen_without_movers(const SceneModel& model, const SceneDescription& scene, const HeadBoxes& boxes,
                                       const ClientModelOptions& options) {
    constexpr float out_of_sight_m = 1e7f;
    const std::vector<std::uint32_t> movers = find_moving_instances(model, scene);
    Bvh bvh(model, {.moving_instances = movers});
    std::vector<glm::mat4> transforms(model.instances.size());
    for (std::size_t i = 0; i < transforms.size(); ++i)
        transforms[i] = model.instances[i].world_from_object;
    for (const std::uint32_t mover : movers)
        transforms[mover][3] += glm::vec4(0, -out_of_sight_m, 0, 0);
    if (!movers.empty())
        bvh.move(transforms);
    return find_seen(model, bvh, boxes, options.visibility_rays, options.seed);
}

}  // namespace

ClientModel build_client_model(const SceneModel& model, const SceneDescription& scene,
                               const ClientModelOptions& options, const std::function<void(const std::string&)>& told) {
    require_options(options, scene);
    const auto tell = [&](const std::string& step) {
        if (told)
            told(step);
    };
    ClientModel out;
    ClientModelFigures& figures = out.figures;
    figures.box_radius_m = head_box_radius_centre(scene.head_radius_m, options.ipd_m);
    figures.triangles_before = model.triangle_count();
    figures.unique_before = model.unique_triangle_count();
    const HeadBoxes boxes(scene.camera_path, figures.box_radius_m);
    figures.centres = boxes.centres().size();
    figures.cell_m = boxes.cell_m();
    figures.added_m = boxes.added_m();

    tell("finding visible surfaces");
    auto start = Clock::now();
    const Bvh bvh(model);
    ModelDraft draft(model, scene, boxes, options.error_rad);
    draft.keep(find_seen_without_movers(model, scene, boxes, options));
    figures.visibility_s = seconds_since(start);
    figures.triangles_seen = draft.kept_triangles();

    for (figures.rounds = 1; figures.rounds <= options.rounds; ++figures.rounds) {
        tell(formatted("simplifying, round %d", figures.rounds));
        start = Clock::now();
        out.model = draft.build();
        figures.simplify_s += seconds_since(start);
        if (out.model.triangle_count() == 0)
            throw InputError(expected_found(scene.file.string(), "surfaces visible from the camera path", "none"));
        tell(formatted("checking %lld rays, round %d", static_cast<long long>(options.check_rays), figures.rounds));
        start = Clock::now();
        const Bvh ours(out.model);
        std::vector<FailedRay> failed;
        figures.check = check_by_rays(
            bvh, ours, boxes,
            {options.error_rad, options.silhouette_rad, options.check_rays, options.seed + seed_step * figures.rounds},
            failed);
        figures.check_s += seconds_since(start);
        figures.holds = figures.check.kept() >= options.kept_quantile;
        if (figures.holds || figures.rounds == options.rounds)
            break;
        draft.restore(failed);
    }
    figures.triangles_after = out.model.triangle_count();
    figures.unique_after = out.model.unique_triangle_count();
    return out;
}

namespace {

/// The file that is there stays the same one, as whoever has locked it needs.
void write_in_place(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file, std::ios::binary);
    out << text << std::flush;
    const int descriptor = out ? open(file.c_str(), O_WRONLY | O_CLOEXEC) : -1;
    const bool is_kept = descriptor >= 0 && fsync(descriptor) == 0;
    const int problem = errno;
    if (descriptor >= 0)
        close(descriptor);
    if (!is_kept)
        throw WorkError(file.string() + ": cannot be written: " + std::strerror(problem));
}

}  // namespace

void write_client_model(const std::filesystem::path& json_file, const ClientModel& model,
                        const SceneDescription& scene) {
    SceneDescription description = scene;
    description.sun.reset();
    description.sky_image.reset();
    description.sky_radiance = glm::dvec3(0);
    description.model = std::filesystem::path(json_file).replace_extension(".glb");
    description.model_unit_m = 1;
    description.stands_for = scene.geometry_fingerprint;
    // An object without triangles is not in the model, so its motion is left out.
    std::erase_if(description.moving, [&](const MovingObject& moving) {
        return std::ranges::none_of(model.model.objects,
                                    [&](const Object& object) { return object.name == moving.object; });
    });
    const std::filesystem::path unfinished = unfinished_description(json_file);
    std::error_code error;
    try {
        write_in_place(unfinished, description_text(description));
        write_glb(description.model, model.model);
    } catch (...) {  // geometry alone, of a run that was killed, needs it
        if (std::filesystem::exists(json_file, error) || !std::filesystem::exists(description.model, error))
            std::filesystem::remove(unfinished, error);
        throw;
    }
    std::filesystem::rename(unfinished, json_file, error);
    if (error)
        throw WorkError(json_file.string() + ": cannot be written: " + error.message());
}

std::filesystem::path unfinished_description(std::filesystem::path json_file) {
    return json_file += ".part";
}

namespace {

void append(void* bytes, void* data, int size) {
    const auto* first = static_cast<const std::uint8_t*>(data);
    auto* to = static_cast<std::vector<std::uint8_t>*>(bytes);
    to->insert(to->end(), first, first + size);
}

}  // namespace

Texture mask_texture(const AlphaMask& mask, const std::string& name) {
    std::vector<std::uint8_t> grey_alpha(mask.opaque.size() * 2, 255);
    for (std::size_t i = 0; i < mask.opaque.size(); ++i)
        grey_alpha[2 * i + 1] = mask.opaque[i];
    Texture texture;
    texture.name = name;
    texture.mime_type = "image/png";
    texture.wrap_u = mask.wrap_u;
    texture.wrap_v = mask.wrap_v;
    texture.nearest = true;
    if (stbi_write_png_to_func(append, &texture.encoded, mask.width, mask.height, 2, grey_alpha.data(),
                               2 * mask.width) == 0)
        throw WorkError("the alpha mask of material '" + quotable(name, 300) + "' could not be encoded");
    return texture;
}

}  // namespace equistream
