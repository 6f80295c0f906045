#pragma once
/// Clients of OpenGL in a context of the test's own, and what they draw into.
#include "client_folder.h"

#include <client/gpu/context.h>
#include <client/gpu/objects.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace equistream::test {

class GlClients : public ClientFolder {
protected:
    const std::unique_ptr<gl::Context> context = gl::make_offscreen_context();

    /// Of what the folder's frames show, as triangles.
    std::string write_scene() const {
        write_model(folder / "room.obj");
        const std::string scene = (folder / "room.json").string();
        std::ofstream(scene)
            << R"({"model": "room.obj", "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]}})";
        return scene;
    }
    static double psnr_db(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
        return 10 * std::log10(255.0 * 255.0 / (sum / double(a.size()) + 1e-9));
    }

    /// What both render for a request, compared eye by eye.
    template <typename Compare>
    void expect_alike(Client& cpu, Client& drawn, const es_client_request& request, double min_psnr_db,
                      Compare compare) {
        ClientPicture expected[2], found[2];
        cpu.render(request, expected);
        drawn.render(request, found);
        for (int i = 0; i < 2; ++i) {
            SCOPED_TRACE(i);
            ASSERT_EQ(found[i].rgba.size(), expected[i].rgba.size());
            EXPECT_GT(psnr_db(found[i].rgba, expected[i].rgba), min_psnr_db);
            compare(found[i], expected[i]);
        }
    }
};

inline gl::Framebuffer empty_framebuffer() {
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    return gl::Framebuffer(name);
}

inline es_gl_target target_at(GLuint framebuffer, int x, int y) {
    es_gl_target target{};
    target.framebuffer = framebuffer;
    target.x = x;
    target.y = y;
    return target;
}

/// A framebuffer of a host's, of one texture.
struct HostPicture {
    static constexpr std::uint8_t untouched = 77;

    explicit HostPicture(gl::Size picture_size, GLenum format = GL_RGBA8)
        : size(picture_size), texture(gl::make_texture(size, format)) {
        glNamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, texture.name(), 0);
    }
    void clear() const {
        const std::vector<std::uint8_t> plain(bytes(), untouched);
        glTextureSubImage2D(texture.name(), 0, 0, 0, size.width, size.height, GL_RGBA, GL_UNSIGNED_BYTE, plain.data());
    }
    es_gl_target at(int x, int y) const { return target_at(framebuffer.name(), x, y); }
    std::size_t bytes() const { return 4 * std::size_t(size.width) * std::size_t(size.height); }
    /// Rows upwards.
    std::vector<std::uint8_t> pixels() const {
        std::vector<std::uint8_t> all(bytes());
        glGetTextureImage(texture.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(all.size()), all.data());
        return all;
    }
    /// What an eye that was drawn at x, y makes of pixels().
    void draw_into(std::vector<std::uint8_t>& all, const ClientPicture& eye, int x, int y) const {
        for (int row = 0; row < eye.height; ++row) {
            const std::size_t to = std::size_t(y + eye.height - 1 - row) * std::size_t(size.width) + std::size_t(x);
            std::copy_n(&eye.rgba[4 * std::size_t(row) * std::size_t(eye.width)], 4 * eye.width, &all[4 * to]);
        }
    }

    gl::Size size;
    gl::Texture texture;
    gl::Framebuffer framebuffer = empty_framebuffer();
};

}  // namespace equistream::test
