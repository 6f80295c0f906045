/// What the conversion to Mitsuba XML computes itself; what Mitsuba makes of the files is tests/hosts's.
#include <scenes/mitsuba/asset_folder.h>
#include <scenes/mitsuba/lights.h>
#include <scenes/mitsuba/materials.h>
#include <scenes/mitsuba/old_scene.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace equistream::mitsuba_xml {
namespace {

/// Fresnel's equations with a complex index, as textbooks have them.
double reflectance(const ComplexIndex& index, double cosine) {
    const std::complex<double> n(index.eta, index.k), c(cosine, 0);
    const std::complex<double> inside = std::sqrt(1.0 - (1 - cosine * cosine) / (n * n));
    const double s = std::norm((c - n * inside) / (c + n * inside));
    const double p = std::norm((n * c - inside) / (n * c + inside));
    return 0.5 * (s + p);
}

TEST(SchlickConductor, FollowsSchlicksCurve) {
    for (const double f0 : {0.02, 0.2, 0.5, 0.8, 0.95}) {
        const ComplexIndex index = schlick_conductor(f0);
        EXPECT_NEAR(reflectance(index, 1), f0, 1e-6);
        double difference = 0, mean = 0;
        for (int i = 0; i < 1000; ++i) {
            const double cosine = (i + 0.5) / 1000;
            const double apart = reflectance(index, cosine) - (f0 + (1 - f0) * std::pow(1 - cosine, 5));
            difference = std::max(difference, std::abs(apart));
            mean += 2 * cosine * apart / 1000;
        }
        RecordProperty("worst at F0 " + std::to_string(f0), std::to_string(difference));
        EXPECT_LT(std::abs(mean), 0.01) << f0;
        EXPECT_LT(difference, 0.12) << f0;
    }
}

Mesh two_triangles(glm::vec2 low, glm::vec2 high) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.uvs = {low, {high.x, low.y}, high, {low.x, high.y}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

TEST(TexturedLight, IsSampledOnlyWhereItsMapIsOneToOne) {
    EXPECT_TRUE(maps_one_to_one(two_triangles({0, 0}, {1, 1})));
    EXPECT_TRUE(maps_one_to_one(two_triangles({0.25f, 1}, {0.5f, 0})));
    EXPECT_FALSE(maps_one_to_one(two_triangles({0, 0}, {2, 1})));
    EXPECT_FALSE(maps_one_to_one(two_triangles({0, 0}, {0, 1})));
    Mesh twice = two_triangles({0, 0}, {1, 1});
    twice.triangles.push_back({0, 1, 3});
    EXPECT_FALSE(maps_one_to_one(twice));
    Mesh without = two_triangles({0, 0}, {1, 1});
    without.uvs.clear();
    EXPECT_FALSE(maps_one_to_one(without));
}

}  // namespace
}  // namespace equistream::mitsuba_xml

// What an earlier conversion wrote.

namespace equistream::test {
namespace {

class Assets : public TemporaryFolder {};

TEST_F(Assets, ThoseOfAnEarlierConversionComeBackWhateverFails) {
    const std::filesystem::path mesh = write("scene.files/mesh.ply", "earlier");
    {
        mitsuba_xml::AssetFolder assets(folder_ / "scene.xml", true);
        assets.place();
        EXPECT_FALSE(std::filesystem::exists(mesh));
    }
    EXPECT_TRUE(std::filesystem::exists(mesh)) << "after the folder was put in its place";
    {
        mitsuba_xml::AssetFolder assets(folder_ / "scene.xml", true);
        std::filesystem::remove_all(folder_ / ".scene.files.aside");
        EXPECT_THROW(assets.place(), WorkError);
    }
    EXPECT_TRUE(std::filesystem::exists(mesh)) << "after it could not be put there";
}

TEST_F(Assets, ThoseThatCannotBePutBackStayWhereTheyAre) {
    const std::filesystem::path mesh = write(".scene.files.earlier.aside/mesh.ply", "the only copy");
    std::filesystem::create_symlink("nowhere", folder_ / "scene.files");
    EXPECT_THROW(mitsuba_xml::AssetFolder(folder_ / "scene.xml", true), WorkError);
    EXPECT_TRUE(std::filesystem::exists(mesh));
}

}  // namespace
}  // namespace equistream::test

// What must change in scenes of Mitsuba 0.6.

namespace equistream::test {
namespace {

class OldScene : public TemporaryFolder {
protected:
    /// Without the folder.
    std::vector<std::string> changes(const std::string& text) const {
        std::vector<std::string> list = mitsuba_xml::changes_for_mitsuba3(write("scene.xml", text));
        for (std::string& change : list) {
            EXPECT_EQ(change.rfind(folder_.string() + "/", 0), 0u) << change;
            change.erase(0, folder_.string().size() + 1);
        }
        return list;
    }
    using List = std::vector<std::string>;
};

TEST_F(OldScene, AllIsSaidAtOnce) {
    EXPECT_EQ(changes(R"(<?xml version="1.0"?>
<scene>
  <integrator type="bdpt"><boolean name="strictNormals" value="true"/></integrator>
  <sensor type="perspective"><transform name="toWorld"><lookAt origin="0,1,3" target="0,1,0"/></transform>
    <sampler type="sobol"/><film type="ldrfilm"/></sensor>
  <bsdf type="phong" id="a"><spectrum name="diffuseReflectance" value="0.3, 0.2, 0.1"/>
    <srgb name="specularReflectance" value="#ffffff"/></bsdf>
  <bsdf type="diffuse" id="b"><texture type="bitmap" name="reflectance">
    <string name="filterType" value="trilinear"/></texture></bsdf>
  <bsdf type="diffuse" id="c"><texture type="bitmap" name="reflectance">
    <string name="filterType" value="trilinear"/></texture></bsdf>
  <shape type="sphere"><emitter type="area"><blackbody name="radiance" temperature="3000K"/></emitter></shape>
</scene>)"),
              (List{
                  "scene.xml:2: write <scene version=\"0.6.0\">: Mitsuba 3 then renames toWorld and the like by itself",
                  "scene.xml:3: write the integrator path in place of bdpt",
                  "scene.xml:3: leave out strictNormals",
                  "scene.xml:4: write the element lookat in place of lookAt",
                  "scene.xml:5: write the sampler multijitter in place of sobol",
                  "scene.xml:5: write the film hdrfilm in place of ldrfilm",
                  "scene.xml:6: write the bsdf roughplastic in place of phong",
                  "scene.xml:6: write the element rgb in place of spectrum: its values are red, green, blue",
                  "scene.xml:7: write the element rgb in place of srgb",
                  "scene.xml:9: write the filterType bilinear in place of trilinear (2 times)",
                  "scene.xml:12: write <spectrum type=\"blackbody\"> with a <float name=\"temperature\"> in place of "
                  "<blackbody>",
              }));
}

TEST_F(OldScene, NamesAreRenamedByMitsubaOnlyInOldVersions) {
    const auto scene = [](const std::string& version) {
        return "<scene version=\"" + version + "\"><shape type=\"sphere\">\n<transform name=\"toWorld\"/>\n" +
               "<bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"1.5\"/></bsdf></shape></scene>";
    };
    EXPECT_EQ(changes(scene("0.6.0")), List{});
    EXPECT_EQ(changes(scene("3.0.0")), (List{"scene.xml:2: write the name to_world in place of toWorld",
                                             "scene.xml:3: write the name int_ior in place of intIOR"}));
}

TEST_F(OldScene, FilesThatAreIncludedAreReadOnce) {
    write("part.xml", "<scene version=\"0.5.0\">\n<sampler type=\"halton\"/><include filename=\"scene.xml\"/></scene>");
    EXPECT_EQ(changes("<scene version=\"0.5.0\"><include filename=\"part.xml\"/><include filename=\"part.xml\"/>"
                      "<include filename=\"$none.xml\"/></scene>"),
              List{"part.xml:2: write the sampler multijitter in place of halton"});
}

TEST_F(OldScene, AGoodSceneHasNothingToChange) {
    EXPECT_EQ(changes("<scene version=\"3.0.0\"><default name=\"sampleCount\" value=\"4\"/><integrator type=\"path\"/>"
                      "<bsdf type=\"plastic\"><spectrum name=\"diffuse_reflectance\" value=\"400:0.1, 500:0.2\"/>"
                      "</bsdf><emitter type=\"constant\"><spectrum name=\"radiance\" value=\" 0.5 \"/></emitter>"
                      "</scene>"),
              List{});
}

TEST_F(OldScene, WhatIsNoXmlIsRefusedWithItsLine) {
    expect_contains(input_error([&] { changes("<scene>\n<shape></scene>"); }), "scene.xml:2: expected a scene in Mit");
    expect_contains(input_error([&] { changes(""); }), "expected a scene in Mitsuba's XML");
    expect_contains(input_error([&] { mitsuba_xml::changes_for_mitsuba3(folder_ / "none.xml"); }), "no such file");
}

TEST_F(OldScene, DeepAndLongFilesTakeNoTime) {
    std::string deep = "<scene version=\"3.0.0\">";
    for (int i = 0; i < 100000; ++i)
        deep += "<shape><srgb name=\"aB" + std::to_string(i) + "\"/>\n";
    for (int i = 0; i < 100000; ++i)
        deep += "</shape>";
    const List list = changes(deep + "</scene>");
    ASSERT_EQ(list.size(), 100001u);
    EXPECT_EQ(list.back(), "scene.xml:100000: write the name a_b99999 in place of aB99999");
}

}  // namespace
}  // namespace equistream::test
