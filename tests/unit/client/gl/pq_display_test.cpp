/// HDR planes on the GPU come to the display as OpenColorIO's own processor brings them there on the CPU.
#include "gl_fixture.h"
#include "hdr_picture.h"
#include "made_objects.h"

#include <client/warp/gl/source_textures.h>
#include <tests/unit/scenes/generate/scratch_folder.h>

#include <equistream/colour.h>
#include <equistream/error.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

namespace equistream::test {
namespace {

ByteImage downloaded(const gl::SourceTextures& textures) {
    ByteImage rgba(HdrPicture::width, HdrPicture::height, 4);
    glGetTextureImage(textures.colour(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(rgba.samples().size()),
                      rgba.samples().data());
    return rgba;
}

class GlPqDisplay : public Gl {
protected:
    static void expect_same(const HdrDisplaySettings& settings) {
        const HdrPicture picture;
        const HdrDisplay display(settings);
        gl::SourceTextures textures;
        textures.show_pq_by(std::make_shared<gl::PqDisplay>(display));
        picture.upload_to(textures);
        const ByteImage expected = on_the_cpu(picture, settings);
        EXPECT_GE(psnr_db(downloaded(textures), expected), 50);
        const auto [least, most] = std::ranges::minmax(expected.samples());
        EXPECT_LT(least, 20);
        EXPECT_GT(most, 180) << "black and white are both in it";
    }
};

TEST_F(GlPqDisplay, IsOpenColorIosProcessor) {
    expect_same({});
    expect_same(Chosen{.exposure_stops = -4.5});
    expect_same(Chosen{.view = "ACES 1.0 - SDR Video"});
    expect_same(Chosen{.view = "ACES 1.0 - SDR Video", .exposure_stops = 1});
    expect_same(Chosen{.display = "P3-D65 - Display", .view = "ACES 1.0 - SDR Cinema"});
    expect_same(Chosen{.display = "Rec.2100-PQ - Display", .view = "ACES 1.1 - HDR Video (1000 nits & Rec.2020 lim)"});
}

/// A config of somebody else's in a folder, whose one view is what `children` do one after the other.
std::string config_of(const ScratchFolder& folder, const char* name, const std::string& children) {
    std::ofstream text(folder / name);
    text << R"(ocio_profile_version: 2
search_path: )"
         << folder.path().string() << R"(
roles: {scene_linear: lin, aces_interchange: aces, default: lin}
displays:
  Wall:
    - !<View> {name: Tables, colorspace: shown}
active_displays: [Wall]
active_views: [Tables]
colorspaces:
  - !<ColorSpace> {name: aces}
  - !<ColorSpace>
    name: lin
    to_scene_reference: !<MatrixTransform> {matrix: [0.44, 0.38, 0.18, 0, 0.09, 0.81, 0.10, 0, 0.02, 0.11, 0.87, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: shown
    from_scene_reference: !<GroupTransform>
      children:
)" << children;
    return (folder / name).string();
}

void write_curve(const ScratchFolder& folder) {
    std::ofstream curve(folder / "curve.spi1d");
    curve << "Version 1\nFrom -0.25 16\nLength 300\nComponents 3\n{\n";
    for (int i = 0; i < 300; ++i) {
        const double x = -0.25 + 16.25 * i / 299, shown = x <= 0 ? 0 : std::pow(x / (1 + x), 0.5);
        curve << shown << ' ' << 0.98 * shown << ' ' << 0.95 * shown << '\n';
    }
    curve << "}\n";
}

constexpr const char* curve_step = "        - !<FileTransform> {src: curve.spi1d, interpolation: linear}\n";

/// A view through a curve in a file and a cube in another.
TEST_F(GlPqDisplay, ReadsTheTablesOfAnyConfig) {
    const ScratchFolder folder("ocio");
    write_curve(folder);
    std::ofstream cube(folder / "cube.cube");
    constexpr int edge = 17;
    cube << "LUT_3D_SIZE " << edge << '\n';
    const auto along = [](int i) { return double(i) / (edge - 1); };
    for (int b = 0; b < edge; ++b)
        for (int g = 0; g < edge; ++g)
            for (int r = 0; r < edge; ++r)
                cube << along(r) * (1 - 0.2 * along(g)) << ' ' << 0.8 * along(g) + 0.2 * along(r) * along(b) << ' '
                     << std::sqrt(along(b)) << '\n';
    cube.close();
    const auto config = [&](const char* name, const std::string& interpolation) {
        return config_of(folder, name,
                         curve_step +
                             ("        - !<FileTransform> {src: cube.cube, interpolation: " + interpolation + "}\n"));
    };
    const HdrDisplaySettings tetrahedral = Chosen{.config = config("a.ocio", "tetrahedral")};
    const DisplayShader shader = HdrDisplay(tetrahedral).shader();
    EXPECT_GE(shader.tables.size(), 2u);
    EXPECT_TRUE(std::ranges::any_of(shader.tables, [](const ShaderTable& table) { return table.depth == edge; }));
    EXPECT_EQ(HdrDisplay(tetrahedral).settings().view, "Tables");
    expect_same(tetrahedral);
    expect_same(Chosen{.config = config("b.ocio", "linear"), .exposure_stops = -1});
}

/// What a file declares as to be set while it is shown is as the file has it.
TEST_F(GlPqDisplay, LeavesOpenNothingButTheExposure) {
    const ScratchFolder folder("ocio");
    std::ofstream(folder / "open.ctf") << R"(<?xml version="1.0" encoding="UTF-8"?>
<ProcessList version="2" id="open">
    <ExposureContrast inBitDepth="32f" outBitDepth="32f" style="linear">
        <ECParams exposure="-0.1" contrast="1.4" gamma="1.1" pivot="0.18" />
        <DynamicParameter param="EXPOSURE" />
        <DynamicParameter param="CONTRAST" />
        <DynamicParameter param="GAMMA" />
    </ExposureContrast>
</ProcessList>
)";
    write_curve(folder);
    const std::string config =
        config_of(folder, "open.ocio", curve_step + std::string("        - !<FileTransform> {src: open.ctf}\n"));
    expect_same(Chosen{.config = config});
    expect_same(Chosen{.config = config, .exposure_stops = -2});
}

/// The driver finds that neither the table nor the exposure says anything.
TEST_F(GlPqDisplay, ViewsThatShowNothingOfThePictureAreShown) {
    const ScratchFolder folder("ocio");
    write_curve(folder);
    const std::string grey = "        - !<MatrixTransform> {matrix: [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1], "
                             "offset: [0.4, 0.4, 0.4, 0]}\n";
    const HdrDisplay display(Chosen{.config = config_of(folder, "grey.ocio", curve_step + grey)});
    ASSERT_GE(display.shader().tables.size(), 1u);
    const auto shown = std::make_shared<gl::PqDisplay>(display);
    gl::SourceTextures textures;
    textures.show_pq_by(shown);
    shown->set_exposure(1);
    HdrPicture().upload_to(textures);
    EXPECT_EQ(downloaded(textures).pixel(20, 30)[0], 102);
}

TEST_F(GlPqDisplay, MoreTablesThanTheDriverTakesAreOneLine) {
    const ScratchFolder folder("ocio");
    write_curve(folder);
    GLint units = 0;
    glGetIntegerv(GL_MAX_COMPUTE_TEXTURE_IMAGE_UNITS, &units);
    std::string children;
    for (int i = 0; i < units; ++i)
        children += std::string(curve_step) +
                    "        - !<MatrixTransform> {matrix: [0.9, 0.1, 0, 0, 0, 0.9, 0.1, 0, 0.1, "
                    "0, 0.9, 0, 0, 0, 0, 1]}\n";
    const HdrDisplay display(Chosen{.config = config_of(folder, "many.ocio", children)});
    try {
        const gl::PqDisplay shown(display);
        FAIL() << display.shader().tables.size() << " tables were taken";
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()), "OpenColorIO's view: expected at most " + std::to_string(units - 3) +
                                                 " tables, here, found " +
                                                 std::to_string(display.shader().tables.size()));
    }
}

TEST_F(GlPqDisplay, ShowsAPictureAgainByAnotherExposureAndMakesNothingForIt) {
    const HdrPicture picture;
    const auto display = std::make_shared<gl::PqDisplay>(HdrDisplay());
    gl::SourceTextures textures;
    textures.show_pq_by(display);
    picture.upload_to(textures);
    const ByteImage first = downloaded(textures);
    const MadeObjects made_since;
    display->set_exposure(2);
    textures.show_again();
    EXPECT_GE(psnr_db(downloaded(textures), on_the_cpu(picture, Chosen{.exposure_stops = 2})), 50);
    display->set_exposure(0);
    picture.upload_to(textures);
    EXPECT_TRUE(std::ranges::equal(downloaded(textures).samples(), first.samples()));
    EXPECT_EQ(made_since.count(), 0);
}

}  // namespace
}  // namespace equistream::test
