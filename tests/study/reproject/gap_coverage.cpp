/// How much of what random eyes of the head box cannot find in a sphere other pictures show: server-predicted patches
/// at several budgets, the auxiliary spheres whole (what patches could show at best), the hidden layer, the small
/// stream. Gaps are those that the `eye-depth` engine leaves, with the eye's own depth; they are filled by the client's
/// own fill passes. Nothing is rendered: depth comes from ray casts, colours are all one grey. Prints JSON.
#include "random_eyes.h"

#include <client/depth/ray_depth.h>
#include <client/fill/fill.h>
#include <client/warp/engine.h>
#include <plugin/patches/planner.h>

#include <nlohmann/json.hpp>

#include <cstdio>

namespace equistream {
namespace {

struct Options : RandomEyeOptions {
    std::string budgets = "2.5,5,7.5,10,15,20";
    int block_side = PatchSettings{}.block_side, training_eyes = PatchSettings{}.training_eyes;
    double offset_radius = 1;
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
    explicit Coverage(const Options& options)
        : options_(options), scene_(load_scene(options.scene)), depth_(scene_), eyes_(options, scene_) {
        depth_.set_time(eyes_.time_s);
        grey_ = ByteImage(eyes_.sphere.width, eyes_.sphere.height, 3, 128);
        main_ = grey_sphere(eyes_.sphere, glm::dvec3(0));
    }

    nlohmann::json measure() {
        nlohmann::json plans = nlohmann::json::array();
        std::vector<PatchPlan> chosen;
        for (const std::string& budget : between_commas(options_.budgets))
            chosen.push_back(plan(std::stod(budget) / 100));
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
                {"box_radius_m", eyes_.box_radius_m},
                {"block_side", options_.block_side},
                {"training_eyes", options_.training_eyes},
                {"auxiliary_spheres", offsets().size()},
                {"gap_share", share(double(gaps_), double(pixels_))},
                {"patches", plans},
                {"all_auxiliary_spheres", share(double(filled_by_all_), double(gaps_))},
                {"small_stream", share(double(filled_by_small_), double(gaps_))}};
    }

private:
    std::vector<glm::dvec3> offsets() const { return patch_offsets(options_.offset_radius * eyes_.box_radius_m); }

    Pose beside(const glm::dvec3& offset_m) const {
        return {eyes_.centre.position_m + offset_m, eyes_.centre.orientation};
    }

    GreySphere grey_sphere(const EquirectCamera& camera, const glm::dvec3& offset_m) {
        GreySphere sphere{FloatImage(camera.width, camera.height, 1), {}};
        depth_.cast(camera, beside(offset_m), sphere.depth_m.view());
        sphere.view.rgb = grey_.view();
        sphere.view.rgb.width = camera.width;
        sphere.view.rgb.height = camera.height;
        sphere.view.camera = camera;
        sphere.view.pose = beside(offset_m);
        sphere.view.depth_m = sphere.depth_m.view();
        sphere.view.box_radius_m = eyes_.box_radius_m;
        return sphere;
    }

    PatchPlan plan(double budget) {
        PatchSettings settings;
        settings.sphere = eyes_.sphere;
        settings.box_radius_m = eyes_.box_radius_m;
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
                if (slot.used && at.u < eyes_.sphere.width && at.v < eyes_.sphere.height)
                    depth_m.pixel(x, y)[0] = auxiliary[slot.offset_index].depth_m.pixel(int(at.u), int(at.v))[0];
            }
        return depth_m;
    }

    std::int64_t fill(const char* fill_pass, const FillInputs& inputs, const EyeView& eye, EyePicture picture) const {
        const FillChain chain = make_fill_chain(fill_pass);
        chain.front()->set_frame(inputs);
        return chain.front()->fill(eye, picture);
    }

    void look_out(const std::vector<PatchPlan>& plans) {
        std::vector<GreySphere> auxiliary;
        std::vector<SourceView> whole;
        for (const glm::dvec3& offset : offsets()) {
            auxiliary.push_back(grey_sphere(eyes_.sphere, offset));
            whole.push_back(auxiliary.back().view);
        }
        std::vector<FloatImage> depths;
        for (const PatchPlan& plan : plans)
            depths.push_back(atlas_depth(plan.atlas, auxiliary));
        const GreySphere small = grey_sphere({eyes_.sphere.width / 4, eyes_.sphere.height / 4, eyes_.sphere.range},
                                             glm::dvec3(0.5 * default_ipd_m, 0, 0));
        const auto engine = make_engine("eye-depth");
        engine->set_source(main_.view);
        filled_.assign(plans.size(), 0);
        std::mt19937_64 generator = eyes_.generator();
        FloatImage depth_m(eyes_.eye.width, eyes_.eye.height, 1);
        for (int i = 0; i < eyes_.count; ++i) {
            const Pose pose = eyes_.next(generator);
            depth_.cast(eyes_.eye, pose, depth_m.view());
            const EyeView eye{eyes_.eye, pose, depth_m.view()};
            EyePicture picture;
            engine->reproject(eye, picture);
            gaps_ += picture.count(PixelOrigin::gap);
            pixels_ += std::int64_t{eyes_.eye.width} * eyes_.eye.height;
            for (std::size_t k = 0; k < plans.size(); ++k) {
                PatchesView view;
                view.rgb = grey_.view();  // only its size matters: an atlas is smaller than a sphere
                view.rgb.width = plans[k].atlas.width();
                view.rgb.height = plans[k].atlas.height();
                view.depth_m = depths[k].view();
                view.atlas = &plans[k].atlas;
                view.pose = eyes_.centre;
                view.box_radius_m = eyes_.box_radius_m;
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

    Options options_;
    SceneDescription scene_;
    RayDepth depth_;
    RandomEyes eyes_;
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
        [&](cli::CommandLine& app) {
            add_random_eye_options(app, options);
            app.add_option("--budgets", options.budgets, "Percent of the sphere's pixels").with_default();
            app.add_option("--side", options.block_side, "Pixels a patch is wide and high").with_default();
            app.add_option("--training-eyes", options.training_eyes, "Of the planner").with_default();
            app.add_option("--offsets", options.offset_radius, "Radius of the auxiliary spheres' centres in head boxes")
                .with_default();
            return [&options] { std::printf("%s\n", Coverage(options).measure().dump(1).c_str()); };
        });
}
