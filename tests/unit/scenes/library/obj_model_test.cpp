// Geometry of OBJ files, and what is wrong with them.
#include <tests/unit/scenes/temporary_folder.h>

#include <equistream/elapsed.h>

#include <scenes/library/scene.h>

#include <cmath>
#include <numeric>

namespace equistream::test {

namespace {

constexpr const char* square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

class ObjModel : public TemporaryFolder {
protected:
    SceneModel load(const std::string& text, const ModelOptions& options = {}) const {
        return load_model(write("model.obj", text), options);
    }
    /// The error without the folder.
    std::string error(const std::string& text) const {
        const std::string message = input_error([&] { load(text); });
        return message.substr(std::min(message.size(), folder_.string().size() + 1));
    }
};

double area(const Mesh& mesh) {
    double sum = 0;
    for (const glm::uvec3& t : mesh.triangles)
        sum += 0.5 * glm::length(glm::cross(glm::dvec3(mesh.positions[t.y] - mesh.positions[t.x]),
                                            glm::dvec3(mesh.positions[t.z] - mesh.positions[t.x])));
    return sum;
}

/// Of all triangles, as far as it is the same.
glm::vec3 facing(const Mesh& mesh) {
    glm::vec3 sum{0};
    for (const glm::uvec3& t : mesh.triangles)
        sum += glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
    return glm::normalize(sum);
}

}  // namespace

TEST_F(ObjModel, PolygonsOfAnyShapeKeepTheirAreaAndWinding) {
    struct Case {
        const char* name;
        std::string text;
        double area;
        std::size_t triangles;
    };
    const Case cases[] = {
        {"square", std::string(square) + "f 1 2 3 4\n", 1, 2},
        {"counted from the end", std::string(square) + "f -4 -3 -2 -1\n", 1, 2},
        {"dart, hollow at its second corner", "v 0 0 0\nv 1 1 0\nv 2 0 0\nv 1 3 0\nf 1 2 3 4\n", 2, 2},
        {"dart, hollow at its third", "v 1 3 0\nv 0 0 0\nv 1 1 0\nv 2 0 0\nf 1 2 3 4\n", 2, 2},
        {"L", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n", 3, 4},
        {"comb",
         "v 0 0 0\nv 5 0 0\nv 5 2 0\nv 4 2 0\nv 4 1 0\nv 3 1 0\nv 3 2 0\nv 2 2 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n"
         "f 1 2 3 4 5 6 7 8 9 10 11 12\n",
         8, 10},
        {"corners said twice", std::string(square) + "f 1 1 2 3 3 4 1\n", 1, 2},
        {"straight corner", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4 5\n", 2, 3},
    };
    for (const Case& c : cases) {
        const SceneModel model = load(c.text);
        ASSERT_EQ(model.meshes.size(), 1u) << c.name;
        EXPECT_NEAR(area(model.meshes[0]), c.area, 1e-6) << c.name;
        EXPECT_EQ(model.meshes[0].triangles.size(), c.triangles) << c.name;
        EXPECT_GT(facing(model.meshes[0]).z, 0.999f) << c.name;
        EXPECT_TRUE(model.notes.empty()) << c.name << ": " << model.notes[0];
    }
    // A thousand corners round a circle, in a slanting plane.
    std::string text, face = "f";
    for (int i = 0; i < 1000; ++i) {
        const double angle = 2 * std::acos(-1.0) * i / 1000;
        text += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " " +
                std::to_string(std::cos(angle)) + "\n";
        face += " " + std::to_string(i + 1);
    }
    EXPECT_NEAR(area(load(text + face + "\n").meshes[0]), std::acos(-1.0) * std::sqrt(2.0), 1e-3);
}

/// Of which each corner is judged a few times: two arcs, one beside the other.
TEST_F(ObjModel, AFaceOfManyCornersTakesNoTime) {
    constexpr int corners = 4096;
    std::string text, face = "f";
    for (int i = 0; i < corners; ++i) {
        const bool out = i < corners / 2;
        const double angle = std::acos(-1.0) * (out ? i : corners - 1 - i) / (corners / 2 - 1.0),
                     radius = out ? 1 : 0.999;
        text +=
            "v " + std::to_string(radius * std::cos(angle)) + " " + std::to_string(radius * std::sin(angle)) + " 0\n";
        face += " " + std::to_string(i + 1);
    }
    for (int i = 0; i < 20; ++i)
        text += face + "\n";
    const auto start = Clock::now();
    const SceneModel model = load(text);
    EXPECT_LT(seconds_since(start), 60) << "minutes, where all corners are judged for each triangle";
    const double expected = 20 * std::acos(-1.0) / 2 * (1 - 0.999 * 0.999);
    EXPECT_NEAR(area(model.meshes[0]), expected, 0.01 * expected);
}

TEST_F(ObjModel, LinesThatGoOnWithoutEndTakeNoTime) {
    std::string text = std::string(square) + "f 1 ";
    for (int i = 0; i < 200000; ++i)
        text += i % 2 == 0 ? "\\\n" : "  \\\n";
    const auto start = Clock::now();
    EXPECT_EQ(load(text + " 2 3\n").triangle_count(), 1u);
    EXPECT_LT(seconds_since(start), 10);
    // Two at the end of a line are one more than is needed: the empty line behind is joined too.
    EXPECT_EQ(load(std::string(square) + "f 1 2 \\\\\n\n 3\n").triangle_count(), 1u);
}

TEST_F(ObjModel, TextIsReadHoweverItIsLaidOut) {
    const std::string plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const SceneModel expected = load(plain);
    for (const std::string& text :
         {std::string("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n"),
          std::string("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3"),
          std::string(
              "\xef\xbb\xbf# by hand\nv\t0 0\t0  \n  v +1.0e0 0 -0 # a corner\nv 0 1 0 1 0 0\n\nf  1// 2/  3\t \n"),
          std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nf +1 +2 +3\n"),
          std::string("v 0 0 0\nv 1 0 0\nv 0 1 \\\n 0\nf 1 \\\r\n2 \\  \n 3")}) {
        const SceneModel model = load(text);
        EXPECT_EQ(model.meshes[0].positions, expected.meshes[0].positions) << text;
        EXPECT_EQ(model.meshes[0].triangles, expected.meshes[0].triangles) << text;
        EXPECT_TRUE(model.notes.empty()) << text;
    }
}

TEST_F(ObjModel, FacesWithoutAnAreaAreLeftOutWithOneNote) {
    const SceneModel model = load(std::string(square) + "f 1 2 3\nf 1 1 2\nf 1 2\nf 1 2 1\nv 2 0 0\nf 1 2 5\n");
    EXPECT_EQ(model.triangle_count(), 1u);
    ASSERT_EQ(model.notes.size(), 1u);
    expect_contains(model.notes[0], "model.obj:6: a face without an area is left out (and 3 more)");
}

TEST_F(ObjModel, ObjectsAndGroupsAreNamedAndMaterialsSplitThem) {
    write("m.mtl", "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n");
    const SceneModel model = load(std::string("mtllib m.mtl\n") + square +
                                  "o car\ng body\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\ng wheel left\nf 1 2 3\n"
                                  "o car\ng body\nusemtl a\nf 2 3 4\no house\ng house\nf 1 2 3\n");
    std::vector<std::string> names, meshes;
    for (const Object& object : model.objects)
        names.push_back(object.name + "/" + std::to_string(object.parent));
    for (const Mesh& mesh : model.meshes)
        meshes.push_back(mesh.name + " " + std::to_string(mesh.triangles.size()));
    EXPECT_EQ(names, (std::vector<std::string>{"car/-1", "body/0", "wheel left/0", "house/-1"}));
    EXPECT_EQ(meshes, (std::vector<std::string>{"body#a 2", "body#b 1", "wheel left#b 1", "house#a 1"}));
    SceneDescription scene;
    scene.moving = {{"car", PosePath({{0, {{0, 0, 5}, {1, 0, 0, 0}}}}, "test")}};
    EXPECT_EQ(find_moving_instances(model, scene), (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(instance_transforms(model, scene, 0)[2][3], glm::vec4(0, 0, 5, 1));
    scene.moving[0].object = "body";
    EXPECT_EQ(find_moving_instances(model, scene), (std::vector<std::uint32_t>{0, 1}));
    EXPECT_EQ(load(std::string(square) + "f 1 2 3\n").objects[0].name, "default");
    EXPECT_EQ(load(std::string(square) + "g\nf 1 2 3\n").objects[0].name, "default");
}

TEST_F(ObjModel, NormalsAreTheFilesOrSmoothedByGroupOrNone) {
    // Two walls of a corner along z, the first facing +y, the second +x.
    const std::string walls = "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 1 0 1\nv 0 -1 0\nv 0 -1 1\n";
    const std::string up = "f 1 2 4 3\n", side = "f 1 5 6 2\n";
    const SceneModel flat = load(walls + "s off\n" + up + side);
    EXPECT_TRUE(flat.meshes[0].normals.empty());
    const SceneModel smooth = load(walls + "s 1\n" + up + side);
    ASSERT_EQ(smooth.meshes[0].positions.size(), 6u);
    int shared = 0;
    for (std::size_t i = 0; i < 6; ++i) {
        const glm::vec3 p = smooth.meshes[0].positions[i], n = smooth.meshes[0].normals[i];
        EXPECT_NEAR(glm::length(n), 1, 1e-6);
        if (p.x == 0 && p.y == 0) {
            ++shared;
            EXPECT_NEAR(glm::length(glm::cross(n, glm::normalize(glm::vec3(facing(flat.meshes[0]))))), 0, 1e-5);
        }
    }
    EXPECT_EQ(shared, 2);
    // Other groups, and none beside one: the edge stays sharp.
    for (const std::string& text : {walls + "s 1\n" + up + "s 2\n" + side, walls + "s 1\n" + up + "s 0\n" + side}) {
        const SceneModel sharp = load(text);
        EXPECT_GE(sharp.meshes[0].positions.size(), 8u);
        for (const glm::vec3& n : sharp.meshes[0].normals)
            EXPECT_NEAR(std::max(std::abs(n.x), std::abs(n.y)), 1, 1e-6);
    }
    const SceneModel given = load(walls + "vn 0 2 0\nvn -1.#IND 0 0\nf 1//1 2//1 4//1\nf 1//2 4//2 3//2\n");
    EXPECT_EQ(given.meshes[0].normals[0], glm::vec3(0, 1, 0));
    EXPECT_EQ(given.meshes[0].normals[3], glm::vec3(0)) << "one without a length is left to the renderer";
    expect_contains(given.notes.at(0), "model.obj:8: a number of vn is none: taken as 0");
    EXPECT_TRUE(load(walls + "s 1\n" + up, {.shading = false}).meshes[0].normals.empty());
}

/// A card that is seen from both sides, tilted so that rounding leaves something.
TEST_F(ObjModel, NormalsThatCancelEachOtherAreLeftToTheRenderer) {
    const SceneModel card =
        load("v 0.1 0.2 0.3\nv 1.3 0.7 0.1\nv 1.1 1.9 0.4\nv -0.1 1.4 0.6\ns 1\nf 1 2 3 4\nf 4 3 2 1\n");
    ASSERT_EQ(card.meshes[0].normals.size(), card.meshes[0].positions.size());
    for (const glm::vec3& normal : card.meshes[0].normals)
        EXPECT_EQ(normal, glm::vec3(0));
}

TEST_F(ObjModel, NumbersTooLargeForFloatsCountAsZero) {
    write("m.mtl", "newmtl a\nmap_Kd a.tga\n");
    // The second is 0 times infinity to a reader that scales by powers of ten.
    const std::string uvs = "vt 1e300 0.25\nvt 0e9999 0.5\nvt 0.5 -1e300\n";
    write("a.tga", std::string("\0\0\3\0\0\0\0\0\0\0\0\0\1\0\1\0\10\0\200", 19));  // one grey texel
    const SceneModel model =
        load("mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\n" + uvs + "vn 1e300 0 1\nf 1/1/1 2/2/1 3/3/1\n");
    ASSERT_EQ(model.meshes[0].uvs.size(), 3u);
    EXPECT_EQ(model.meshes[0].uvs[0], glm::vec2(0, 0.75f));
    EXPECT_EQ(model.meshes[0].uvs[1], glm::vec2(0, 0.5f));
    EXPECT_EQ(model.meshes[0].uvs[2], glm::vec2(0.5f, 1));
    EXPECT_EQ(model.meshes[0].normals[0], glm::vec3(0, 0, 1));
    ASSERT_EQ(model.notes.size(), 2u);
    expect_contains(model.notes[0], "model.obj:6: a number of vt is too large: taken as 0");
    expect_contains(model.notes[1], "model.obj:9: a number of vn is too large: taken as 0");
}

TEST_F(ObjModel, TheUnitScalesModelsAndIsPartOfTheGeometrysFingerprint) {
    write("model.obj", std::string(square) + "f 1 2 3 4\n");
    const auto describe = [&](const std::string& unit) {
        return load_scene(
            write("scene.json", "{\"model\": \"model.obj\"" + unit +
                                    ", \"camera\": {\"keys\": [{\"time_s\": 0, \"position_m\": [0, 0, 0]}]}}"));
    };
    const SceneDescription centimetres = describe(", \"model_unit_m\": 0.01");
    EXPECT_EQ(centimetres.model_unit_m, 0.01);
    const SceneModel model = load_model(centimetres);
    EXPECT_EQ(glm::vec3(model.instances[0].world_from_object * glm::vec4(1, 1, 0, 1)), glm::vec3(0.01f, 0.01f, 0));
    EXPECT_NE(centimetres.geometry_fingerprint, describe("").geometry_fingerprint);
    EXPECT_EQ(describe(", \"model_unit_m\": 1").geometry_fingerprint, describe("").geometry_fingerprint);
    expect_contains(input_error([&] { describe(", \"model_unit_m\": 0"); }),
                    "scene.json:1: expected a number from 1e-6");
}

TEST_F(ObjModel, WhatGeometryWouldSufferFromIsAnErrorWithItsLine) {
    EXPECT_EQ(error("v 0 0 0\n\nv 1 x 0\n"), "model.obj:3: expected numbers after v, found x");
    EXPECT_EQ(error("v 0 0 nan\n"), "model.obj:1: expected numbers after v, found nan");
    EXPECT_EQ(error("v 1 2\n"), "model.obj:1: expected 3 numbers after v, found 2");
    EXPECT_EQ(error("v 0 0 2e9\n"), "model.obj:1: expected coordinates from -1e9 to 1e9, found one outside");
    const std::string so_far = "expected one of the 4 vertices so far (1 is the first, -1 the last), found ";
    EXPECT_EQ(error(std::string(square) + "f 1 2 5\n"), "model.obj:5: " + so_far + "5");
    EXPECT_EQ(error(std::string(square) + "f 1 2 -5\n"), "model.obj:5: " + so_far + "-5");
    EXPECT_EQ(error(std::string(square) + "f 0 1 2\n"), "model.obj:5: " + so_far + "0");
    const std::string corner = "model.obj:5: expected corners like 1, 1/2, 1//3 or 1/2/3 after f, found ";
    for (const char* bad : {"4294967297", "1.5", "1/2/3/4", "x", "--1", "+-1", "+", "1-2", "/1", "x/", "4294967297/",
                            "1/x/", "1/2/3/", "/", "//"})
        EXPECT_EQ(error(std::string(square) + "f 1 2 " + bad + "\n"), corner + bad);
    EXPECT_EQ(error(std::string("v 0 0 0\nv \0 1 2\n", 16)), "model.obj:2: expected text, found a zero byte");
    EXPECT_EQ(error("v 0 0 0\n"), "model.obj: expected at least one triangle, found none");
    EXPECT_EQ(error(""), "model.obj: expected at least one triangle, found none");
    std::string many = square;
    many += "f";
    for (int i = 0; i < 5000; ++i)
        many += " " + std::to_string(i % 4 + 1);
    EXPECT_EQ(error(many + "\n"), "model.obj:5: expected a face of at most 4096 corners, found 5000");
    expect_contains(error("# \n" + std::string(2 << 20, 'v')), "model.obj:2: expected a line below 1 MiB");
}

TEST_F(ObjModel, WhatMerelyLooksWorseIsANote) {
    const SceneModel model = load(std::string("mtllib gone.mtl\n") + square +
                                  "usemtl fog\nf 1/9 2 3\nfoo 1\nfoo 2\ncurv 1\ns blunt\nf 1 3 4\n");
    const std::vector<std::string> expected = {"model.obj:1: no material file \"gone.mtl\": left out",
                                               "model.obj:7: a vt or vn that does not exist: left out",
                                               "model.obj:8: \"foo\" is not used (and 1 more)",
                                               "model.obj:10: \"curv\" is not used",
                                               "model.obj:11: a smoothing group that is no number: taken as off",
                                               "model.obj:6: no material \"fog\": grey"};
    ASSERT_EQ(model.notes.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_EQ(model.notes[i], (folder_ / expected[i]).string());
    const Material& grey = model.materials[model.meshes[0].material];
    EXPECT_EQ(grey.base_colour, glm::vec3(0.8f));
    EXPECT_EQ(grey.metallic, 0);
}

}  // namespace equistream::test
