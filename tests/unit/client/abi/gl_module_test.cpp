/// OpenGL's module by what it exports, with frames of the test's own.
#include <client/abi/module_loading.h>
#include <tests/unit/client/gl/gl_fixture.h>
#include <tests/unit/client/gl/hdr_picture.h>

#include <array>
#include <memory>
#include <utility>

extern "C" const equistream::ExportedModule<equistream::GlModule> equistream_client_module_gl;

namespace equistream::test {
namespace {

using GlModuleEyes = Gl;

/// A track need not say that it is HDR, and a server may become so.
TEST_F(GlModuleEyes, ShowHdrThatNobodyAnnounced) {
    const PerspectiveCamera camera{HdrPicture::width, HdrPicture::height, pi / 2};
    const auto frame = [&](std::int64_t index) {
        auto made = std::make_shared<ReceivedFrame>();
        made->main.info.index = index;
        made->main.info.time_s = double(index) / 30;
        made->main.info.camera = camera;
        return made;
    };
    const HdrPicture picture;
    const auto plain = frame(0), hdr = frame(1), other_hdr = frame(2);
    plain->main.rgb = ByteImage(camera.width, camera.height, 3, 40);
    hdr->main.pq = other_hdr->main.pq = {picture.planes(), nullptr};
    const auto eyes = equistream_client_module_gl.functions.eyes(
        {.engine = "rotation", .fill = "none", .by_depth = false, .exposure_stops = 1});
    const std::array views = {EyeView{camera, {}}, EyeView{camera, {}}};
    const auto shown = [&](const std::shared_ptr<const ReceivedFrame>& next) {
        eyes->show(next);
        eyes->render(views, 0);
        EyePicture seen;
        FloatImage depth_m;
        eyes->download(1, seen, depth_m);
        return std::move(seen.rgba);
    };
    EXPECT_EQ(shown(plain).pixel(20, 30)[1], 40);
    const ByteImage expected = on_the_cpu(picture, Chosen{.exposure_stops = 1});
    EXPECT_GE(psnr_db(shown(hdr), expected), 45);
    EXPECT_GE(psnr_db(shown(other_hdr), expected), 45);
    EXPECT_EQ(shown(plain).pixel(20, 30)[1], 40);
}

}  // namespace
}  // namespace equistream::test
