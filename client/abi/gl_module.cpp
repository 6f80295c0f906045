/// OpenGL's module of libequistream_client: the viewer's renderer in a context of the host's.
#include "host_gl_state.h"
#include "module_loading.h"

#include <client/gpu/context.h>
#include <client/gpu/program.h>
#include <client/view/gl/eye_renderer.h>
#include <client/warp/gl/source_textures.h>

#include <client/depth/gl/gl_depth.h>
#include <equistream/error.h>
#include <equistream/text.h>

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

    void require_planes(const GlHostPlanes& planes, int width, int height, const std::string& name) const override {
        require_plane(planes.origin, {name + ".origin", "GL_R8UI", GL_R8UI}, {width, height});
        require_plane(planes.depth_m, {name + ".depth_m", "GL_R32F", GL_R32F}, {width, height});
        require_plane(planes.confidence, {name + ".confidence", "GL_R8", GL_R8}, {width, height});
        if (planes.confidence != 0 && !settings_.confidence)
            throw InputError(expected_found(name + ".confidence", "a client that was opened with confidence",
                                            "one that was opened without"));
    }

    void write_planes(int eye, const ViewPart& part, const GlHostPlanes& to) override {
        const gl::HostGlState kept;
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

    GlEyesTextures textures() const override {
        const gl::EyeDepth depth = renderer_.depth();
        return {targets_.colour(), targets_.origin(), depth.texture, settings_.confidence ? renderer_.reliability() : 0,
                depth.texture != 0 ? depth.scale : 0};
    }

private:
    struct PlaneFormat {
        std::string name;
        const char* format_name;
        GLenum format;
    };

    static void require_plane(GLuint texture, const PlaneFormat& expected, gl::Size size) {
        if (texture == 0)
            return;
        GLint format = 0, width = 0, height = 0, target = 0, is_immutable = 0;
        if (glIsTexture(texture) == GL_TRUE) {
            glGetTextureParameteriv(texture, GL_TEXTURE_TARGET, &target);
            glGetTextureParameteriv(texture, GL_TEXTURE_IMMUTABLE_FORMAT, &is_immutable);
            glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
            glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_WIDTH, &width);
            glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_HEIGHT, &height);
        }
        if (GLenum(format) != expected.format || GLenum(target) != GL_TEXTURE_2D || is_immutable == 0 ||
            width < size.width || height < size.height)
            throw InputError(expected_found(
                expected.name,
                std::string("a GL_TEXTURE_2D with immutable storage of ") + expected.format_name + ", " +
                    std::to_string(size.width) + "x" + std::to_string(size.height) + " at least",
                format == 0 ? std::string("none of that name")
                            : formatted("one of target 0x%x, format 0x%x, ", unsigned(target), unsigned(format)) +
                                  std::to_string(width) + "x" + std::to_string(height)));
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
        glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
        glGetTextureSubImage(depth.texture, 0, 0, 0, eye, camera.width, camera.height, 1, GL_RED, GL_FLOAT,
                             GLsizei(depth_m.samples().size_bytes()), depth_m.samples().data());
        const double focal_px = camera.focal_px();
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
    std::optional<gl::Program> part_planes_;
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
    equistream::code_identity(), {.depth = equistream::make_depth_by_gl, .eyes = equistream::make_eyes}};
