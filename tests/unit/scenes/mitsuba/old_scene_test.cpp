/// What must change in scenes of Mitsuba 0.6.
#include <tests/unit/scenes/temporary_folder.h>

#include <scenes/mitsuba/old_scene.h>

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
