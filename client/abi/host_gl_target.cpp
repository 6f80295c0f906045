#include "host_gl_target.h"

#include <equistream/error.h>
#include <equistream/text.h>

namespace equistream::gl {

namespace {

/// Whether a blit can write all that the framebuffer, which is bound, draws to. There has to be something.
bool takes_colours(GLuint framebuffer) {
    GLint most = 0;
    glGetIntegerv(GL_MAX_DRAW_BUFFERS, &most);
    bool takes = false;
    for (GLenum i = 0; i < GLenum(most); ++i) {
        GLint drawn = GL_NONE, object = GL_NONE, type = GL_NONE;
        glGetIntegerv(GL_DRAW_BUFFER0 + i, &drawn);
        if (drawn == GL_NONE)
            continue;
        if (framebuffer == 0)
            return true;  // a window has no integers
        const auto get = [&](GLenum what, GLint& value) {
            glGetNamedFramebufferAttachmentParameteriv(framebuffer, GLenum(drawn), what, &value);
        };
        get(GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, object);
        if (object == GL_NONE)
            continue;
        get(GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE, type);
        if (type == GL_INT || type == GL_UNSIGNED_INT)
            return false;
        takes = true;
    }
    return takes;
}

void require_framebuffer(GLuint framebuffer, const std::string& name) {
    const auto require = [&](bool right, const std::string& found) {
        if (!right)
            throw InputError(
                expected_found(name, "a complete framebuffer with a colour attachment, not of integers", found));
    };
    require(framebuffer == 0 || glIsFramebuffer(framebuffer) == GL_TRUE, "no framebuffer of this name");
    const GLenum status = glCheckNamedFramebufferStatus(framebuffer, GL_DRAW_FRAMEBUFFER);
    require(status == GL_FRAMEBUFFER_COMPLETE, formatted("a framebuffer of status 0x%x", unsigned(status)));
    GLint bound = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    const bool takes = takes_colours(framebuffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, GLuint(bound));
    require(takes, "no colour attachment, or one of integers");
}

struct PlaneFormat {
    std::string name;
    const char* format_name;
    GLenum format;
};

void require_plane(GLuint texture, const PlaneFormat& expected, Size size) {
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
                size_text(size.width, size.height) + " at least",
            format == 0 ? std::string("no texture of this name")
                        : formatted("a texture of target 0x%x, format 0x%x, ", unsigned(target), unsigned(format)) +
                              size_text(width, height)));
}

}  // namespace

void require_host_target(const GlHostTarget& target, Size size, bool has_confidence, const std::string& name) {
    require_framebuffer(target.framebuffer, name + ".framebuffer");
    require_plane(target.origin, {name + ".origin", "GL_R8UI", GL_R8UI}, size);
    require_plane(target.depth_m, {name + ".depth_m", "GL_R32F", GL_R32F}, size);
    require_plane(target.confidence, {name + ".confidence", "GL_R8", GL_R8}, size);
    if (target.confidence != 0 && !has_confidence)
        throw InputError(expected_found(name + ".confidence", "a client that was opened with confidence",
                                        "one that was opened without"));
}

}  // namespace equistream::gl
