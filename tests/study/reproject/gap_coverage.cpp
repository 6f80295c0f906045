/// How much of what random eyes of the head box cannot find in a sphere other pictures show: server-predicted patches
/// at several budgets, the auxiliary spheres whole (what patches could show at best), the hidden layer, the small
/// stream. Gaps are those that the `surface` engine leaves, with the eye's own depth; they are filled by the client's
/// own rungs. Nothing is rendered: depth comes from ray casts, colours are all one grey. Prints JSON.
#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream_cli/program.h>
#include <equistream_client/engine.h>
#include <equistream_client/fill.h>
#include <equistream_client/ray_depth.h>
#include <equistream_patches/planner.h>

#include <nlohmann/json.hpp>

#include <cstdio>
#include <random>

namespace equistream {
namespace {

struct Options {
    std::string scene, size = "640x360", sphere = "1920x960", budgets = "2.5,5,7.5,10,15,20";
    std::int64_t frame = 0;
    int eyes = 64, block_side = PatchSettings{}.block_side, training_eyes = PatchSettings{}.training_eyes;
    double lean_m = -1, offset_radius = 1;
    std::uint64_t seed = 1;
};

double share(double part, double whole) {
    return whole > 0 ? part / whole : 1;
}

/// A sphere of depth with nothing to see on it.
struct GreySphere {
    FloatImage depth_m;
    SourceView view;
};

class Coverage {
public:
    explicit Coverage(const Options& options) : options_(options), scene_(load_scene(options.scene)), depth_(scene_) {
        const double time_s = double(options.frame) / scene_.frames_per_second;
        depth_.set_time(time_s);
        centre_ = {scene_.camera_path.at(time_s).position_m, {1, 0, 0, 0}};
        const cli::Size sphere = cli::parse_size(options.sphere), eye = cli::parse_size(options.size);
        sphere_ = {sphere.width, sphere.height, {}};
        eye_camera_ = {eye.width, eye.height, pi / 2};
        box_radius_m_ = head_box_radius_centre(options.lean_m < 0 ? scene_.lean_m : options.lean_m, default_ipd_m);
        grey_ = ByteImage(sphere.width, sphere.height, 3, 128);
        main_ = grey_sphere(sphere_, glm::dvec3(0));
    }

    nlohmann::json measure() {
        nlohmann::json plans = nlohmann::json::array();
        std::vector<PatchPlan> chosen;
        for (std::size_t start = 0; start <= options_.budgets.size();) {
            const std::size_t comma = std::min(options_.budgets.find(',', start), options_.budgets.size());
            chosen.push_back(plan(std::stod(options_.budgets.substr(start, comma - start)) / 100));
            start = comma + 1;
        }
        look_out(chosen);
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            const PatchFigures& f = chosen[i].figures;
            plans.push_back({{"pixel_share", f.pixel_share},
                             {"covered", share(double(filled_[i]), double(gaps_))},
                             {"covered_of_training", f.covered},
                             {"coverable_of_training", f.coverable},
                             {"plan_s", f.plan_s},
                             {"cast_s", f.cast_s}});
        }
        return {{"scene", scene_.name},
                {"frame", options_.frame},
                {"sphere", options_.sphere},
                {"eye", options_.size},
                {"eyes", options_.eyes},
                {"seed", options_.seed},
                {"box_radius_m", box_radius_m_},
                {"block_side", options_.block_side},
                {"training_eyes", options_.training_eyes},
                {"auxiliary_spheres", offsets().size()},
                {"gap_share", share(double(gaps_), double(pixels_))},
                {"patches", plans},
                {"all_auxiliary_spheres", share(double(filled_by_all_), double(gaps_))},
                {"small_stream", share(double(filled_by_small_), double(gaps_))}};
    }

private:
    std::vector<glm::dvec3> offsets() const { return patch_offsets(options_.offset_radius * box_radius_m_); }

    Pose beside(const glm::dvec3& offset_m) const { return {centre_.position_m + offset_m, centre_.orientation}; }

    GreySphere grey_sphere(const EquirectCamera& camera, const glm::dvec3& offset_m) {
        GreySphere sphere{FloatImage(camera.width, camera.height, 1), {}};
        depth_.cast(camera, beside(offset_m), sphere.depth_m.view());
        sphere.view.rgb = grey_.view();
        sphere.view.rgb.width = camera.width;
        sphere.view.rgb.height = camera.height;
        sphere.view.camera = camera;
        sphere.view.pose = beside(offset_m);
        sphere.view.depth_m = sphere.depth_m.view();
        sphere.view.box_radius_m = box_radius_m_;
        return sphere;
    }

    PatchPlan plan(double budget) {
        PatchSettings settings;
        settings.sphere = sphere_;
        settings.box_radius_m = box_radius_m_;
        settings.budget = budget;
        settings.block_side = options_.block_side;
        settings.training_eyes = options_.training_eyes;
        settings.offsets_m = offsets();
        return plan_patches(settings,
                            [this](const glm::dvec3& offset_m, const EquirectCamera& camera, ImageView<float> depth_m) {
                                depth_.cast(camera, beside(offset_m), depth_m);
                            });
    }

    /// The atlas's depth, from whole auxiliary spheres.
    FloatImage atlas_depth(const PatchAtlas& atlas, const std::vector<GreySphere>& auxiliary) const {
        FloatImage depth_m(atlas.width(), atlas.height(), 1, std::nanf(""));
        for (int y = 0; y < atlas.height(); ++y)
            for (int x = 0; x < atlas.width(); ++x) {
                const PatchAtlas::Slot& slot = atlas.slot_at(x, y);
                const auto at = patch_sphere_pixel(atlas, x, y, x, y);
                if (slot.used && at.u < sphere_.width && at.v < sphere_.height)
                    depth_m.pixel(x, y)[0] = auxiliary[slot.offset_index].depth_m.pixel(int(at.u), int(at.v))[0];
            }
        return depth_m;
    }

    std::int64_t fill(const char* rung, const FillInputs& inputs, const EyeView& eye, EyePicture picture) const {
        const FillLadder ladder = make_fill_ladder(rung);
        ladder.front()->set_frame(inputs);
        return ladder.front()->fill(eye, picture);
    }

    void look_out(const std::vector<PatchPlan>& plans) {
        std::vector<GreySphere> auxiliary;
        std::vector<SourceView> whole;
        for (const glm::dvec3& offset : offsets()) {
            auxiliary.push_back(grey_sphere(sphere_, offset));
            whole.push_back(auxiliary.back().view);
        }
        std::vector<FloatImage> depths;
        for (const PatchPlan& plan : plans)
            depths.push_back(atlas_depth(plan.atlas, auxiliary));
        const GreySphere small =
            grey_sphere({sphere_.width / 4, sphere_.height / 4, sphere_.range}, glm::dvec3(0.5 * default_ipd_m, 0, 0));
        const auto engine = make_engine("surface");
        engine->set_source(main_.view);
        filled_.assign(plans.size(), 0);
        std::mt19937_64 generator(options_.seed);
        FloatImage depth_m(eye_camera_.width, eye_camera_.height, 1);
        for (int i = 0; i < options_.eyes; ++i) {
            const Pose pose = random_eye(generator);
            depth_.cast(eye_camera_, pose, depth_m.view());
            const EyeView eye{eye_camera_, pose, depth_m.view()};
            EyePicture picture;
            engine->reproject(eye, picture);
            gaps_ += picture.count(PixelOrigin::gap);
            pixels_ += std::int64_t{eye_camera_.width} * eye_camera_.height;
            for (std::size_t k = 0; k < plans.size(); ++k) {
                PatchesView view;
                view.rgb = grey_.view();  // only its size matters: an atlas is smaller than a sphere
                view.rgb.width = plans[k].atlas.width();
                view.rgb.height = plans[k].atlas.height();
                view.depth_m = depths[k].view();
                view.atlas = &plans[k].atlas;
                view.pose = centre_;
                FillInputs inputs;
                inputs.main = &main_.view;
                inputs.patches = &view;
                filled_[k] += fill("patches", inputs, eye, picture);
            }
            FillInputs inputs;
            inputs.main = &main_.view;
            inputs.small = &small.view;
            filled_by_small_ += fill("small", inputs, eye, picture);
            inputs.earlier = whole;
            filled_by_all_ += fill("earlier", inputs, eye, picture);
        }
    }

    /// Uniform in the ball, turned uniformly.
    Pose random_eye(std::mt19937_64& generator) const {
        std::uniform_real_distribution<double> side(-1, 1);
        std::normal_distribution<double> normal;
        glm::dvec3 place;
        do
            place = {side(generator), side(generator), side(generator)};
        while (glm::length(place) > 1);
        glm::dquat turned;
        turned.w = normal(generator);
        turned.x = normal(generator);
        turned.y = normal(generator);
        turned.z = normal(generator);
        return {centre_.position_m + box_radius_m_ * place, glm::normalize(turned)};
    }

    Options options_;
    SceneDescription scene_;
    RayDepth depth_;
    Pose centre_;
    EquirectCamera sphere_;
    PerspectiveCamera eye_camera_;
    double box_radius_m_ = 0;
    ByteImage grey_;
    GreySphere main_;
    std::int64_t pixels_ = 0, gaps_ = 0, filled_by_all_ = 0, filled_by_small_ = 0;
    std::vector<std::int64_t> filled_;
};

}  // namespace
}  // namespace equistream

int main(int argc, char** argv) {
    using namespace equistream;
    Options options;
    return cli::run_program(
        argc, argv,
        {"gap_coverage", "Measures how much of what random eyes uncover patches show",
         "equistream_gap_coverage scenes/descriptions/sponza-crytek.json --frame 62"},
        [&](CLI::App& app) {
            app.add_option("SCENE", options.scene, "Scene description")->required();
            app.add_option("--frame", options.frame, "Of the scene's path")->capture_default_str();
            app.add_option("--sphere-size", options.sphere, "Of the source")->capture_default_str();
            app.add_option("--size", options.size, "Of an eye, 90 degrees wide")->capture_default_str();
            app.add_option("--eyes", options.eyes, "How many")->check(CLI::Range(1, 100000))->capture_default_str();
            app.add_option("--seed", options.seed, "Of the eyes")->capture_default_str();
            app.add_option("--budgets", options.budgets, "Percent of the sphere's pixels")->capture_default_str();
            app.add_option("--side", options.block_side, "Pixels a patch is wide and high")->capture_default_str();
            app.add_option("--training-eyes", options.training_eyes, "Of the planner")->capture_default_str();
            app.add_option("--offsets", options.offset_radius, "Radius of the auxiliary spheres' centres in head boxes")
                ->capture_default_str();
            app.add_option("--lean", options.lean_m, "Head box in metres instead of the scene's");
            return [&options] { std::printf("%s\n", Coverage(options).measure().dump(1).c_str()); };
        });
}
