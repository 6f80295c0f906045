/// OpenGL's module of libequistream_client: the viewer's renderer in a context of the host's.
#include "host_gl_state.h"
#include "module_loading.h"

#include <client/gpu/requirements.h>
#include <client/view/gl/eye_renderer.h>
#include <client/warp/gl/pq_display.h>

#include <client/depth/gl/gl_depth.h>
#include <equistream/error.h>

#include <cmath>
#include <limits>
#include <utility>

namespace equistream {

namespace {

class EyesOfRenderer : public GlEyes {
public:
    explicit EyesOfRenderer(const GlEyesSettings& settings)
        : settings_(settings), renderer_(settings.scene, settings.box_radius_m, settings.fill, settings.engine) {
        if (settings.hdr_display)
            renderer_.show_pq_by(std::make_shared<gl::PqDisplay>(*settings.hdr_display));
        GLuint names[2];
        glCreateFramebuffers(1, names);
        part_ = gl::Framebuffer(names[0]);
    }

    void show(std::shared_ptr<const ReceivedFrame> frame) override {
        const gl::HostGlState kept;
        renderer_.show(std::move(frame), times_);
    }
    bool has_depth() const override { return renderer_.has_depth(); }
    bool can_extrapolate() const override { return settings_.by_depth && renderer_.can_extrapolate(); }

    void render(std::span<const EyeView> eyes, double extrapolation_s) override {
        const gl::HostGlState kept;
        eyes_.assign(eyes.begin(), eyes.end());
        renderer_.extrapolate(extrapolation_s);
        renderer_.look(eyes, settings_.by_depth, times_);
        renderer_.draw(
            {.surface = settings_.by_depth, .reliability = settings_.confidence, .mirrors = settings_.mirrors},
            targets_, times_);
    }

    void download(int eye, EyePicture& picture, FloatImage& depth_m) override {
        const gl::HostGlState kept;
        targets_.download(eye, picture);
        if (settings_.confidence)
            renderer_.download_reliability(eye, picture);
        download_depth(eye, depth_m);
    }

    void blit(int eye, const ViewPart& part, std::uint32_t framebuffer, int x, int y) override {
        const gl::HostGlState kept;
        glDisable(GL_FRAMEBUFFER_SRGB);  // colours are encoded already
        glDisable(GL_SCISSOR_TEST);
        glNamedFramebufferTextureLayer(part_.name(), GL_COLOR_ATTACHMENT0, targets_.colour(), 0, eye);
        glNamedFramebufferReadBuffer(part_.name(), GL_COLOR_ATTACHMENT0);
        // Eyes' rows run down, a framebuffer's up.
        glBlitNamedFramebuffer(part_.name(), framebuffer, part.left, part.top + part.height, part.left + part.width,
                               part.top, x, y, x + part.width, y + part.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    }

    GlEyesTextures textures() const override {
        const gl::EyeDepth depth = renderer_.depth();
        return {targets_.colour(), targets_.origin(), depth.texture, settings_.confidence ? renderer_.reliability() : 0,
                depth.texture != 0 ? depth.scale : 0};
    }

private:
    void download_depth(int eye, FloatImage& depth_m) const {
        const PerspectiveCamera& camera = eyes_[std::size_t(eye)].camera;
        if (depth_m.width() != camera.width || depth_m.height() != camera.height)
            depth_m = FloatImage(camera.width, camera.height, 1);
        const gl::EyeDepth depth = renderer_.depth();
        if (depth.texture == 0) {
            std::ranges::fill(depth_m.samples(), std::numeric_limits<float>::quiet_NaN());
            return;
        }
        glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
        glGetTextureSubImage(depth.texture, 0, 0, 0, eye, camera.width, camera.height, 1, GL_RED, GL_FLOAT,
                             GLsizei(depth_m.samples().size_bytes()), depth_m.samples().data());
        const double focal_px = 0.5 * camera.width / std::tan(0.5 * camera.fov_x_rad);
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                float& sample = depth_m.pixel(x, y)[0];
                const double along_x = (x + 0.5 - 0.5 * camera.width) / focal_px,
                             along_y = (y + 0.5 - 0.5 * camera.height) / focal_px;
                sample = float(std::sqrt(1 + along_x * along_x + along_y * along_y) / (double(sample) * depth.scale));
            }
    }

    GlEyesSettings settings_;
    gl::EyeRenderer renderer_;
    gl::EyeTargets targets_;
    gl::StageTimes times_;
    gl::Framebuffer part_;  ///< that one layer is read through
    std::vector<EyeView> eyes_;
};

std::unique_ptr<GlEyes> make_eyes(const GlEyesSettings& settings) {
    if (const std::string missing = gl::missing_requirement(); !missing.empty())
        throw InputError(expected_found("ES_BACKEND_OPENGL", "a current OpenGL context with " + missing, "another"));
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
    EQUISTREAM_VERSION, {.depth = equistream::make_depth_by_gl, .eyes = equistream::make_eyes}};
