/// A refresh of two 2160x2160 eyes by OpenGL, all of it that `view` does but for its window: a sphere of 3840x1920 and
/// its depth by engine `mesh`, gaps filled by push-pull, the head swaying where the scene's path begins. Against the
/// same by rotation alone, by the scene's own geometry, from a window and a base, and with a new frame each time; and
/// against a copy of the drawn pixels, the machine's limit. Uploads of such frames by themselves: copied or mapped.
#include "bench_scene.h"
#include "eye_stages.h"
#include "gl_figures.h"

#include <client/gpu/context.h>
#include <client/view/gl/eye_renderer.h>
#include <equistream/text.h>
#include <equistream/window.h>

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using namespace equistream;

const PerspectiveCamera headset_eye{2160, 2160, pi / 2};
const EquirectCamera base_camera{640, 320, {}};
constexpr double refreshes_per_second = 90;
constexpr int frames_kept = 3;  ///< what is shown, what is uploaded, and one that the GPU may still read

/// Planes of noise that lie one after another in one piece of memory.
YuvPicture noise_planes(int width, int height, std::shared_ptr<std::uint8_t> memory) {
    const ByteImage luma = bench::noise(width, height, 1), chroma = bench::noise(width / 2, height / 2, 1);
    std::uint8_t* y = memory.get();
    std::uint8_t* cb = y + luma.samples().size();
    std::uint8_t* cr = cb + chroma.samples().size();
    std::memcpy(y, luma.samples().data(), luma.samples().size());
    for (std::uint8_t* plane : {cb, cr})
        std::memcpy(plane, chroma.samples().data(), chroma.samples().size());
    const auto view = [](const std::uint8_t* data, int w, int h) {
        return ImageView<const std::uint8_t>{data, w, h, 1, w};
    };
    return {{view(y, width, height), view(cb, width / 2, height / 2), view(cr, width / 2, height / 2)},
            std::move(memory)};
}

std::shared_ptr<std::uint8_t> own_memory(std::size_t bytes) {
    return {new std::uint8_t[bytes], std::default_delete<std::uint8_t[]>()};
}

std::size_t plane_bytes(const EquirectCamera& camera) {
    return std::size_t(camera.width) * std::size_t(camera.height) * 3 / 2;
}

ReceivedPicture picture(bench::BenchScene& scene, const EquirectCamera& camera, std::shared_ptr<std::uint8_t> memory) {
    ReceivedPicture made;
    made.info.camera = camera;
    made.info.head = scene.description.camera_path.at(0);
    made.info.camera_pose = {made.info.head.position_m, {1, 0, 0, 0}};
    made.info.head_radius_m = scene.description.head_radius_m;
    made.yuv = noise_planes(camera.width, camera.height, std::move(memory));
    made.depth_m = FloatImage(camera.width, camera.height, 1);
    scene.depth.cast(camera, made.info.camera_pose, made.depth_m.view());
    return made;
}

std::shared_ptr<const ReceivedFrame> sphere_frame(bench::BenchScene& scene, std::shared_ptr<std::uint8_t> memory) {
    auto frame = std::make_shared<ReceivedFrame>();
    frame->main = picture(scene, bench::big_sphere, std::move(memory));
    return frame;
}

std::shared_ptr<const ReceivedFrame> window_frame(bench::BenchScene& scene) {
    const WindowGrid grid{bench::big_sphere.width, bench::big_sphere.height, 1920, 1440};
    const glm::dvec3 gaze = scene.description.camera_path.at(0).orientation * glm::dvec3(0, 0, -1);
    const EquirectCamera window = window_camera(grid, window_around(grid, gaze));
    auto frame = std::make_shared<ReceivedFrame>();
    frame->main = picture(scene, window, own_memory(plane_bytes(window)));
    frame->main.info.window_columns = grid.columns;
    frame->base = picture(scene, base_camera, own_memory(plane_bytes(base_camera)));
    return frame;
}

enum class Shown { sphere, window };
enum class Refresh { by_depth, turned, new_frame, upload_alone };

/// A renderer of its own for each way of showing, in one context; kept to the end.
class Eyes {
public:
    const std::unique_ptr<gl::Context> context;

    explicit Eyes(bench::BenchScene& scene) : context(gl::make_offscreen_context()), scene_(scene) {
        buffers_ = std::make_shared<gl::PictureBuffers>();
        const std::size_t bytes = plane_bytes(bench::big_sphere);
        for (int i = 0; i < frames_kept; ++i)
            buffers_->take(bytes);
        buffers_->provide();
        for (int i = 0; i < frames_kept; ++i) {
            copied_.push_back(sphere_frame(scene, own_memory(bytes)));
            if (auto memory = buffers_->take(bytes))
                mapped_.push_back(sphere_frame(scene, std::move(memory)));
        }
    }
    Eyes(const Eyes&) = delete;
    Eyes& operator=(const Eyes&) = delete;

    bool can_map() const { return mapped_.size() == frames_kept; }

    gl::EyeRenderer& renderer(bool with_geometry, Shown shown, bool mapped) {
        std::unique_ptr<gl::EyeRenderer>& kept = renderers_[{with_geometry, shown, mapped}];
        if (!kept) {
            kept = std::make_unique<gl::EyeRenderer>(
                with_geometry ? &scene_.description : nullptr,
                head_box_radius_centre(scene_.description.head_radius_m, default_ipd_m));
            if (mapped)
                kept->read_in_place(buffers_);
            times_.start(false);
            if (shown == Shown::window)
                kept->show(window_frame(scene_), times_);
            else
                kept->show(copied_[0], times_);
        }
        return *kept;
    }
    void show_next(gl::EyeRenderer& renderer, bool mapped) {
        renderer.show((mapped ? mapped_ : copied_)[std::size_t(++shown_ % frames_kept)], times_);
    }
    void draw(gl::EyeRenderer& renderer, bool by_depth) {
        // A head that leans and turns within the head box, as it does between two frames.
        const double s = ++refresh_ / refreshes_per_second;
        Pose head = scene_.description.camera_path.at(0);
        head.position_m += head.orientation * glm::dvec3(0.01 * std::sin(3 * s), 0.01 * std::sin(2 * s), 0);
        head.orientation = head.orientation * glm::angleAxis(0.1 * std::sin(2 * s), glm::dvec3(0, 1, 0));
        const std::array<EyeView, 2> eyes = {
            EyeView{headset_eye, {eye_position(head, Eye::left, default_ipd_m), head.orientation}},
            EyeView{headset_eye, {eye_position(head, Eye::right, default_ipd_m), head.orientation}}};
        renderer.look(eyes, by_depth, times_);
        renderer.draw({.surface = by_depth}, targets_, times_);
    }
    /// The eyes' pixels from one texture to another.
    void copy() {
        if (!copy_)
            copy_ = gl::make_layered_texture(targets_.size(), targets_.eyes(), GL_RGBA8);
        glCopyImageSubData(targets_.colour(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, copy_.name(), GL_TEXTURE_2D_ARRAY, 0, 0,
                           0, 0, targets_.size().width, targets_.size().height, targets_.eyes());
    }
    /// Of the left eye's pixels, how many show the main picture: without its depth most would be filled.
    double seen_percent() const {
        EyePicture picture;
        targets_.download(0, picture);
        return 100.0 * double(picture.count(PixelOrigin::source)) / double(picture.origin.samples().size());
    }
    std::string stages() const {
        std::string text;
        for (std::size_t i = 0; i < gl::render_stage_names.size(); ++i)
            if (times_.row()[i] > 0)
                text += (text.empty() ? "" : ", ") + std::string(gl::render_stage_names[i]) + " " +
                        std::to_string(times_.row()[i]).substr(0, 6);
        return text + " ms (" + gl::Context::driver().renderer + ")";
    }
    void tell_stages_apart() { times_.start(true); }
    void tell_stages_together() { times_.start(false); }

private:
    bench::BenchScene& scene_;
    std::shared_ptr<gl::PictureBuffers> buffers_;
    std::vector<std::shared_ptr<const ReceivedFrame>> copied_, mapped_;
    std::map<std::tuple<bool, Shown, bool>, std::unique_ptr<gl::EyeRenderer>> renderers_;
    gl::EyeTargets targets_;
    gl::Texture copy_;
    gl::StageTimes times_;
    int refresh_ = 0, shown_ = 0;
};

struct Way {
    Refresh refresh = Refresh::by_depth;
    Shown shown = Shown::sphere;
    bool with_geometry = false, mapped = false;
};

void refresh(benchmark::State& state, const char* name, Way way) {
    Eyes* eyes = bench::gl_stage<Eyes>(state, name, bench::bench_scene);
    if (eyes == nullptr)
        return;
    if (way.mapped && !eyes->can_map())
        return state.SkipWithError("this driver maps no buffers for good");
    gl::EyeRenderer& renderer = eyes->renderer(way.with_geometry, way.shown, way.mapped);
    const auto once = [&] {
        if (way.refresh == Refresh::new_frame || way.refresh == Refresh::upload_alone)
            eyes->show_next(renderer, way.mapped);
        if (way.refresh != Refresh::upload_alone)
            eyes->draw(renderer, way.refresh != Refresh::turned);
        glFinish();
    };
    for (int i = 0; i < frames_kept; ++i)
        once();
    for (auto _ : state)
        once();
    eyes->tell_stages_apart();
    once();
    const std::string seen =
        way.refresh == Refresh::upload_alone ? "" : formatted(", %.1f %% seen", eyes->seen_percent());
    state.SetLabel(eyes->stages() + seen);
    eyes->tell_stages_together();
}

void copy(benchmark::State& state, const char* name) {
    Eyes* eyes = bench::gl_stage<Eyes>(state, name, bench::bench_scene);
    if (eyes == nullptr)
        return;
    eyes->draw(eyes->renderer(false, Shown::sphere, false), true);
    eyes->copy();
    glFinish();
    for (auto _ : state) {
        eyes->copy();
        glFinish();
    }
}

[[maybe_unused]] const bool added = [] {
    for (const char* scene : {"pavilion", "sponza-crytek"}) {
        const std::string figure = std::string("gl_refresh_2160_") + scene;
        bench::add_gl_figure(figure + "/ours", refresh, scene, Way{});
        bench::add_gl_figure(figure + "/rotation", refresh, scene, Way{.refresh = Refresh::turned});
        bench::add_gl_figure(figure + "/geometry", refresh, scene, Way{.with_geometry = true});
        bench::add_gl_figure(figure + "/window", refresh, scene, Way{.shown = Shown::window});
        bench::add_gl_figure(figure + "/new_frame", refresh, scene, Way{.refresh = Refresh::new_frame});
        bench::add_gl_figure(figure + "/new_frame_mapped", refresh, scene,
                             Way{.refresh = Refresh::new_frame, .mapped = true});
        bench::add_gl_figure(figure + "/gpu_copy", copy, scene);
        const std::string upload = std::string("gl_upload_3840_") + scene;
        bench::add_gl_figure(upload + "/ours", refresh, scene, Way{.refresh = Refresh::upload_alone, .mapped = true});
        bench::add_gl_figure(upload + "/copied", refresh, scene, Way{.refresh = Refresh::upload_alone});
    }
    return true;
}();

}  // namespace
