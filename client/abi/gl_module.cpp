/// OpenGL's module of libequistream_client: the viewer's renderer in a context of the host's.
#include "host_gl_state.h"
#include "host_gl_target.h"
#include "module_loading.h"

#include <client/gpu/context.h>
#include <client/gpu/program.h>
#include <client/stages/stages.h>
#include <client/view/gl/eye_renderer.h>
#include <client/warp/gl/source_textures.h>

#include <client/depth/gl/gl_depth.h>
#include <equistream/colour.h>
#include <equistream/error.h>

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace equistream {

namespace {

class EyesOfRenderer : public GlEyes {
public:
    explicit EyesOfRenderer(const GlEyesSettings& settings)
        : settings_(settings), renderer_(settings.by_depth ? settings.scene : nullptr, settings.box_radius_m,
                                         settings.fill, settings.engine) {
        GLuint name = 0;
        glCreateFramebuffers(1, &name);
        part_ = gl::Framebuffer(name);
    }

    /// To delete a buffer takes away the binding that the host has at its target.
    ~EyesOfRenderer() override { at_end_.emplace(); }
    EyesOfRenderer(const EyesOfRenderer&) = delete;
    EyesOfRenderer& operator=(const EyesOfRenderer&) = delete;

    void show(std::shared_ptr<const ReceivedFrame> frame) override {
        const gl::HostGlState kept;
        if (!has_hdr_display_ && gl::has_hdr(*frame))
            make_hdr_display();
        renderer_.show(std::move(frame), times_);
    }

    double render(std::span<const EyeView> eyes, double extrapolation_s) override {
        const gl::HostGlState kept;
        eyes_.assign(eyes.begin(), eyes.end());
        renderer_.extrapolate(extrapolation_s);
        renderer_.look(eyes, settings_.by_depth, times_);
        renderer_.draw(
            {.surface = settings_.by_depth, .reliability = settings_.confidence, .mirrors = settings_.mirrors},
            targets_, times_);
        return renderer_.extrapolated_s();
    }

    void download(int eye, EyePicture& picture, FloatImage& depth_m) override {
        const gl::HostGlState kept;
        targets_.download(eye, picture);
        if (settings_.confidence)
            renderer_.download_reliability(eye, picture);
        download_depth(eye, depth_m);
    }

    void require_target(const GlHostTarget& target, int width, int height, const std::string& name) const override {
        gl::require_host_target(target, {width, height}, settings_.confidence, name);
    }

    void write(int eye, const ViewPart& part, const GlHostTarget& to) override {
        const gl::HostGlState kept;
        blit(eye, part, to);
        if (to.origin != 0 || to.depth_m != 0 || to.confidence != 0)
            write_planes(eye, part, to);
    }

    GlEyesTextures textures() const override {
        const gl::EyeDepth depth = renderer_.depth();
        return {targets_.colour(), targets_.origin(), depth.texture, settings_.confidence ? renderer_.reliability() : 0,
                depth.texture != 0 ? depth.scale : 0};
    }

private:
    void blit(int eye, const ViewPart& part, const GlHostTarget& to) const {
        glDisable(GL_FRAMEBUFFER_SRGB);  // colours are encoded already
        glDisable(GL_SCISSOR_TEST);
        glNamedFramebufferTextureLayer(part_.name(), GL_COLOR_ATTACHMENT0, targets_.colour(), 0, eye);
        glNamedFramebufferReadBuffer(part_.name(), GL_COLOR_ATTACHMENT0);
        // Eyes' rows run down, a framebuffer's up.
        glBlitNamedFramebuffer(part_.name(), to.framebuffer, part.left, part.top + part.height, part.left + part.width,
                               part.top, to.x, to.y, to.x + part.width, to.y + part.height, GL_COLOR_BUFFER_BIT,
                               GL_NEAREST);
    }

    void write_planes(int eye, const ViewPart& part, const GlHostTarget& to) {
        const PerspectiveCamera& camera = eyes_[std::size_t(eye)].camera;
        const gl::EyeDepth depth = renderer_.depth();
        if (!part_planes_)
            part_planes_.emplace(std::initializer_list<gl::Stage>{{GL_COMPUTE_SHADER, "part_planes.glsl"}});
        part_planes_->use();
        part_planes_->set("first", glm::ivec3(part.left, part.top, eye));
        part_planes_->set("part_size", glm::ivec2(part.width, part.height));
        part_planes_->set("camera", glm::vec3(camera.focal_px(), camera.width, camera.height));
        part_planes_->set("inverse_depth_scale", depth.texture != 0 ? depth.scale : 0.0f);
        glBindTextureUnit(1, targets_.origin());
        glBindTextureUnit(2, depth.texture);
        glBindTextureUnit(3, settings_.confidence ? renderer_.reliability() : 0);
        glBindImageTexture(0, to.origin, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8UI);
        glBindImageTexture(1, to.depth_m, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
        glBindImageTexture(2, to.confidence, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
        part_planes_->dispatch({part.width, part.height});
        for (const GLuint unit : {0u, 1u, 2u})
            glBindImageTexture(unit, 0, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8);
        glMemoryBarrier(GL_ALL_BARRIER_BITS);
    }

    /// Once the first HDR frame comes: tracks need not say before that they are HDR.
    void make_hdr_display() {
        HdrDisplaySettings chosen;
        chosen.exposure_stops = settings_.exposure_stops;
        renderer_.show_pq_by(std::make_shared<gl::PqDisplay>(HdrDisplay(chosen)));
        has_hdr_display_ = true;
    }

    void download_depth(int eye, FloatImage& depth_m) const {
        const PerspectiveCamera& camera = eyes_[std::size_t(eye)].camera;
        if (depth_m.width() != camera.width || depth_m.height() != camera.height)
            depth_m = FloatImage(camera.width, camera.height, 1);
        const gl::EyeDepth depth = renderer_.depth();
        if (depth.texture == 0) {
            std::ranges::fill(depth_m.samples(), std::numeric_limits<float>::quiet_NaN());
            return;
        }
        gl::download(depth.texture, eye, {camera.width, camera.height}, {depth.format, GL_FLOAT, sizeof(float)},
                     depth_m.samples().data(), sizeof(float) * std::size_t(camera.width));
        const double focal_px = camera.focal_px();
        tbb::parallel_for(0, camera.height, [&](int y) {
            for (int x = 0; x < camera.width; ++x) {
                float& sample = depth_m.pixel(x, y)[0];
                const double along_x = (x + 0.5 - 0.5 * camera.width) / focal_px,
                             along_y = (y + 0.5 - 0.5 * camera.height) / focal_px;
                sample = float(std::sqrt(1 + along_x * along_x + along_y * along_y) / (double(sample) * depth.scale));
            }
        });
    }

    std::optional<gl::HostGlState> at_end_;  ///< goes last
    GlEyesSettings settings_;
    gl::EyeRenderer renderer_;
    gl::EyeTargets targets_;
    gl::StageTimes times_;
    gl::Framebuffer part_;  ///< that one layer is read through
    std::optional<gl::Program> part_planes_;
    std::vector<EyeView> eyes_;
    bool has_hdr_display_ = false;
};

std::unique_ptr<GlEyes> make_eyes(const GlEyesSettings& settings) {
    if (const std::string missing = gl::missing_requirement(); !missing.empty())
        throw InputError(
            expected_found("ES_BACKEND_OPENGL", "a current OpenGL context with " + missing, "one without it, or none"));
    if (settings.scene != nullptr && find_engine(settings.engine).finds_depth)
        throw InputError(expected_found("engine", "eye-depth or rotation, with a scene and ES_BACKEND_OPENGL",
                                        "'" + settings.engine + "'"));
    const gl::HostGlState kept;
    return std::make_unique<EyesOfRenderer>(settings);
}

DrawnDepth make_depth_by_gl(const SceneDescription& scene, bool cube, double box_radius_m) {
    auto drawn = std::make_unique<GlDepth>(scene, GlDepthOptions{.cube = cube, .box_radius_m = box_radius_m});
    std::string driver = drawn->driver();
    return {std::move(drawn), std::move(driver)};
}

}  // namespace

}  // namespace equistream

extern "C" __attribute__((visibility("default"))) const equistream::ExportedModule<equistream::GlModule>
    equistream_client_module_gl;
const equistream::ExportedModule<equistream::GlModule> equistream_client_module_gl = {
    equistream::code_identity(), {.depth = equistream::make_depth_by_gl, .eyes = equistream::make_eyes}};
