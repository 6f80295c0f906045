/// Which views the OpenGL back end shows, and which frames of a damaged stream.
#include "client_folder.h"
#include "watched_client.h"

#include <client/gpu/context.h>
#include <client/gpu/objects.h>

namespace equistream::test {
namespace {

class GlViews : public ClientFolder {
protected:
    const std::unique_ptr<gl::Context> context = gl::make_offscreen_context();
};

/// Both eyes beside each other, `apart` columns apart, from the lower left corner on.
struct Canvas {
    Canvas(gl::Size size, int apart) : texture(gl::make_texture(size, GL_RGBA8)) {
        GLuint name = 0;
        glCreateFramebuffers(1, &name);
        framebuffer = gl::Framebuffer(name);
        glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, texture.name(), 0);
        targets[0].framebuffer = targets[1].framebuffer = name;
        targets[1].x = apart;
    }

    gl::Texture texture;
    gl::Framebuffer framebuffer;
    es_gl_target targets[2] = {};
};

TEST_F(GlViews, TexturesAreOfTheLastPicturesDrawnOrRendered) {
    Client client(settings(ES_BACKEND_OPENGL));
    EXPECT_THROW(client.textures(), ClientError);
    Canvas canvas({330, 100}, 165);
    client.draw(client.request(161, 99, pi / 2), canvas.targets);
    EXPECT_EQ(client.textures().width[0], 161) << "odd sizes are whole";
    ClientPicture eyes[2];
    client.render(client.request(80, 50, pi / 2), eyes);
    const es_gl_textures rendered = client.textures();
    GLint drawn_columns = 0;
    glGetTextureLevelParameteriv(rendered.colour, 0, GL_TEXTURE_WIDTH, &drawn_columns);
    EXPECT_EQ(drawn_columns, 80);
    EXPECT_EQ(rendered.width[0], 80);
    EXPECT_EQ(rendered.height[1], 50);
}

/// Beside each other eyes share an edge.
TEST_F(GlViews, EyesStayInTheirOwnRectangles) {
    Client client(settings(ES_BACKEND_OPENGL));
    for (const int side : {30, 31, 100}) {
        es_client_request request = client.request(side, side, pi / 2);
        request.eyes[0].fov = {-0.9, 0.6, 0.5, -0.7};
        request.eyes[1].fov = {-0.3, 1.1, 0.9, -0.2};
        const gl::Size size{2 * side + 8, side + 8};
        Canvas canvas(size, side);
        const std::uint8_t clear[4] = {1, 2, 3, 4};
        glClearTexImage(canvas.texture.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, clear);
        client.draw(request, canvas.targets);
        std::vector<std::uint8_t> pixels(4 * std::size_t(size.width) * std::size_t(size.height));
        glGetTextureImage(canvas.texture.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(pixels.size()), pixels.data());
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; ++x) {
                const es_gl_target& target = canvas.targets[x >= side];
                ASSERT_LE(target.width, side);
                const bool is_drawn = x - target.x < target.width && y < target.height;
                const std::size_t pixel = std::size_t(y) * std::size_t(size.width) + std::size_t(x);
                ASSERT_EQ(pixels[4 * pixel + 3] != clear[3], is_drawn) << side << ": " << x << ", " << y;
            }
    }
}

TEST_F(GlViews, APictureOfAnotherSizeThanItIsTaggedWithIsPassedOver) {
    const synthetic::Folder streams;
    const std::string file = streams / "a.nut";
    write_with(file, {.other_size = {3}});
    WatchedClient watched(client_settings(file.c_str(), ES_BACKEND_OPENGL));
    expect_all_but_one_frame(watched, 3,
                             "frame 3, main: expected a picture of 384x256, as it is tagged, found 192x128");
}

}  // namespace
}  // namespace equistream::test
