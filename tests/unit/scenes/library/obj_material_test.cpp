// MTL: what its statements mean, and how its files are found. The snippets are built like those of the McGuire archive.
#include <tests/unit/scenes/temporary_folder.h>

#include <scenes/library/scene.h>

#include <cmath>

namespace equistream::test {

namespace {

class ObjMaterial : public TemporaryFolder {
protected:
    /// A square with texture coordinates of the material "m".
    SceneModel load(const std::string& mtl, const ModelOptions& options = {}) const {
        write("m.mtl", mtl);
        return load_model(write("model.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\n"
                                             "vt 1 1\nvt 0 0.75\nusemtl m\nf 1/1 2/2 3/3 4/4\n"),
                          options);
    }
    Material material(const std::string& statements) const {
        const SceneModel model = load("newmtl m\n" + statements);
        EXPECT_TRUE(model.notes.empty()) << statements << model.notes[0];
        return model.materials[model.meshes[0].material];
    }
    std::string note(const std::string& statements) const {
        const SceneModel model = load("newmtl m\n" + statements);
        EXPECT_EQ(model.notes.size(), 1u) << statements;
        return model.notes.empty() ? "" : model.notes[0].substr(folder_.string().size() + 1);
    }
    /// 2x2 RGBA: opaque white, opaque red, cut-away green, half blue.
    std::string save_png(const std::string& name) const {
        write(name, png_rgba(2, 2, {255, 255, 255, 255, 255, 0, 0, 255, 0, 255, 0, 0, 0, 0, 255, 127}));
        return name;
    }
    /// An uncompressed grey TGA, top row first.
    void save_grey_tga(const std::string& name, const std::string& texels, char side) const {
        const std::string header{0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, side, 0, side, 0, 8, 0x20};
        write(name, header + texels);
    }
};

void expect_colour(const glm::vec3& colour, const glm::vec3& expected) {
    EXPECT_NEAR(glm::length(colour - expected), 0, 1e-5) << colour.x << " " << colour.y << " " << colour.z;
}

}  // namespace

TEST_F(ObjMaterial, MattStone) {
    // sibenik.mtl's walls: indented, Tr and d that agree, Ni 1, no specular.
    const Material m = material("\tNs 8.000000\r\n\tNi 1.000000\r\n\td 1.000000\r\n\tTr 0.000000\r\n"
                                "\tTf 1.0 1.0 1.0 \r\n\tillum 2\r\n\tKa 0 0 0\r\n\tKd 0.734118 0.730588 0.674118\r\n"
                                "\tKs 0 0 0\r\n\tKe 0 0 0\r\n");
    expect_colour(m.base_colour, {0.734118f, 0.730588f, 0.674118f});
    EXPECT_EQ(m.index_of_refraction, 1) << "no reflection at all";
    EXPECT_EQ(m.metallic, 0);
    EXPECT_EQ(m.transmission, 0);
    EXPECT_EQ(m.roughness, 1);
    EXPECT_TRUE(m.double_sided);
}

TEST_F(ObjMaterial, GlossAndMetal) {
    const Material varnish = material("Kd 0.3 0.2 0.1\nKs 1 1 1\nNs 30\nNi 1.45\nillum 2\n");
    EXPECT_FLOAT_EQ(varnish.index_of_refraction, 1.45f);
    EXPECT_FLOAT_EQ(varnish.roughness, std::pow(2.0f / 32, 0.25f));
    // conference.mtl: Ks 1 1 1 and nothing else to it.
    const Material plain = material("Kd 0.64 0.6 0.61\nKa 0.64 0.6 0.61\nKs 1 1 1\n");
    EXPECT_FLOAT_EQ(plain.index_of_refraction, 1.5f);
    EXPECT_EQ(plain.roughness, 1);
    const Material gold = material("Kd 0 0 0\nKs 0.9 0.7 0.3\nNs 500\nillum 3\n");
    EXPECT_EQ(gold.metallic, 1);
    expect_colour(gold.base_colour, {0.9f, 0.7f, 0.3f});
    EXPECT_EQ(material("Kd 0.5 0.5 0.5\nKs 1 1 1\nNs 30\nillum 1\n").index_of_refraction, 1)
        << "illum 1 has no highlight";
    const Material pbr = material("Kd 0.5 0.4 0.3\nPr 0.25\nPm 1\n");
    EXPECT_EQ(pbr.metallic, 1);
    EXPECT_EQ(pbr.roughness, 0.25f);
    EXPECT_EQ(material("Ka 1 1 1\n").base_colour, glm::vec3(0.8f)) << "no Kd";
}

TEST_F(ObjMaterial, Glass) {
    // sibenik.mtl's stained glass: d 0, Tf the colour, Kd 0; once with d 1 and glass by its illum alone.
    for (const char* d : {"d 0.000000\n", "d 1.000000\nTr 0.000000\n", "Tr 0.9\n"}) {
        const Material m = material(std::string("Ns 256\nNi 1.0\nTf 0.066667 0.631373 0.074510\nillum 4\nKd 0 0 0\n"
                                                "Ks 0.1 0.1 0.1\n") +
                                    d);
        EXPECT_EQ(m.transmission, 1) << d;
        expect_colour(m.base_colour, {0.066667f, 0.631373f, 0.07451f});
        EXPECT_EQ(m.roughness, 0);
        EXPECT_EQ(m.index_of_refraction, 1.5f) << "Ni 1 would be no glass";
    }
    const Material half = material("Kd 0.4 0 0\nd 0.25\nNi 1.33\n");
    EXPECT_EQ(half.transmission, 0.75f);
    expect_colour(half.base_colour, {0.85f, 0.75f, 0.75f});
    EXPECT_FLOAT_EQ(half.index_of_refraction, 1.33f);
    const Material rough = material("Kd 0.4 0 0\nd 0.25\nNi 1.33\nPr 0.5\n");
    expect_colour(rough.base_colour, half.base_colour);
    EXPECT_EQ(rough.roughness, 0.5f) << "Pr takes Ns's place alone";
    EXPECT_EQ(material("Kd 0.4 0 0\nTr 0.25\n").transmission, 0.25f);
    EXPECT_EQ(material("Kd 0.4 0 0\nTr 0.25\nd 1\n").transmission, 0) << "d counts";
    EXPECT_EQ(material("Kd 0.4 0 0\nd -halo 0.5\n").transmission, 0.5f);
    EXPECT_EQ(material("Kd 0.4 0.4 0.4\nTf 1 1 1\nillum 4\nNi 1.0\n").transmission, 0) << "Maya writes illum 4 for all";
    EXPECT_EQ(note("Kd 0.4 0 0\nTr 1.0\n"), "m.mtl:3: Tr 1 without d would make \"m\" invisible: taken as opaque");
    EXPECT_EQ(note("Kd 0.4 0 0\nd 0\nTr 0\n"), "m.mtl:3: d 0 and Tr 0 contradict each other: \"m\" is taken as opaque");
}

TEST_F(ObjMaterial, Emission) {
    expect_colour(material("Kd 0 0 0\nKe 5 4 3\n").emission, {5, 4, 3});
    const Material textured = material("Kd 0 0 0\nmap_Ke " + save_png("glow.png") + "\n");
    expect_colour(textured.emission, {1, 1, 1});
    EXPECT_NE(textured.emission_texture, no_index);
}

TEST_F(ObjMaterial, TexturesAreFoundHoweverTheyAreWritten) {
    std::filesystem::create_directories(folder_ / "Textures");
    save_png("Textures/Stone Wall.png");
    save_png("Textures/st\xc3\xa4in.png");
    for (const char* name : {"Textures/Stone Wall.png", "textures\\stone wall.PNG", "./Textures//Stone Wall.png",
                             "C:\\work\\scene\\Textures\\Stone Wall.png", "\"Textures\\Stone Wall.png\"",
                             "-clamp on -s 2 3 1 -o 0.5 Textures\\Stone Wall.png", "Textures\\st\xe4in.png",
                             "textures/st\xc3\xa4in.png"}) {
        if (std::string(name).starts_with("C:"))
            save_png("Stone Wall.png");  // by its name alone
        const SceneModel model = load(std::string("newmtl m\nKd 1 1 1\nMap_kd ") + name + "  \n", {});
        ASSERT_EQ(model.textures.size(), 1u) << name;
        EXPECT_TRUE(model.notes.empty()) << name;
        const bool placed = std::string(name).starts_with("-clamp");
        EXPECT_EQ(model.textures[0].wrap_u, placed ? Wrap::clamp : Wrap::repeat);
        // v runs down; the third corner has (1, 1), or by -s and -o (2.5, 3).
        EXPECT_EQ(model.meshes[0].uvs[2], placed ? glm::vec2(2.5f, -2) : glm::vec2(1, 0)) << name;
    }
    // Only map_Ka; a colour under a texture, or what 3ds Max writes there.
    EXPECT_NE(material("map_Ka Stone Wall.png\n").base_colour_texture, no_index);
    expect_colour(material("Kd 0.588 0.588 0.588\nmap_Kd Stone Wall.png\n").base_colour, {1, 1, 1});
    expect_colour(material("Kd 0 0 0\nmap_Kd Stone Wall.png\n").base_colour, {1, 1, 1});
    expect_colour(material("Kd 0.5 0.5 0.25\nmap_Kd Stone Wall.png\n").base_colour, {0.5f, 0.5f, 0.25f});
    EXPECT_EQ(note("map_Kd gone.tga\n"), "m.mtl:2: no file \"gone.tga\": left out");
    write("broken.png", "not an image");
    expect_contains(note("map_Kd broken.png\n"), "broken.png: expected an image (PNG, JPEG, TGA, BMP, DDS or TIFF)");
    EXPECT_EQ(note("map_bump a.png\nmap_Bump b.png\n").find("m.mtl:2: map_bump is not used (and 1 more)"), 0u);
}

TEST_F(ObjMaterial, AnImageIsOneTextureAndOneMaskHoweverItIsWritten) {
    save_png("a.png");
    std::filesystem::create_directories(folder_ / "b");
    std::filesystem::create_symlink("a.png", folder_ / "link.png");
    const std::string shape = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
    std::string mtl, faces;
    for (const std::string name : {"a.png", "./a.png", "b/../a.png", "link.png"}) {
        mtl += "newmtl " + name + "\nmap_Kd " + name + "\n";
        faces += "usemtl " + name + "\nf 1/1 2/2 3/3\n";
    }
    write("m.mtl", mtl);
    const SceneModel model = load_model(write("model.obj", "mtllib m.mtl\n" + shape + faces));
    EXPECT_EQ(model.materials.size(), 5u);
    EXPECT_EQ(model.textures.size(), 1u);
    EXPECT_EQ(model.alpha_masks.size(), 1u);
    EXPECT_EQ(model.textures.at(0).name, "a.png");
}

TEST_F(ObjMaterial, MasksComeFromMapDOrTheColoursOwnAlpha) {
    save_grey_tga("mask.tga", "\xff\x20\x80\x7f", 2);
    write("green.png", png_rgba(1, 1, {0, 255, 0, 255}));
    for (const bool shading : {true, false}) {
        const SceneModel own = load("newmtl m\nKd 1 1 1\nmap_Kd green.png\nmap_d MASK.TGA\n", {.shading = shading});
        ASSERT_EQ(own.alpha_masks.size(), 1u);
        EXPECT_EQ(own.alpha_masks[0].opaque, (std::vector<std::uint8_t>{255, 0, 255, 0}));
        EXPECT_EQ(own.mask_of(own.meshes[0]), 0u);
        EXPECT_EQ(own.textures.size(), shading ? 1u : 0u);
        const SceneModel alpha = load("newmtl m\nmap_Kd " + save_png("leaf.png") + "\n", {.shading = shading});
        ASSERT_EQ(alpha.alpha_masks.size(), 1u);
        EXPECT_EQ(alpha.alpha_masks[0].opaque, (std::vector<std::uint8_t>{255, 255, 0, 0}));
        EXPECT_EQ(load("newmtl m\nmap_Kd leaf.png\nmap_d leaf.png\n", {.shading = shading}).alpha_masks[0].opaque,
                  alpha.alpha_masks[0].opaque);
    }
    const SceneModel whole = load("newmtl m\nmap_Kd green.png\n");
    EXPECT_TRUE(whole.alpha_masks.empty()) << "an alpha that cuts nothing away is none";
    write("bmp32.png", png_rgba(2, 1, {0, 255, 0, 0, 255, 0, 0, 0}));
    const SceneModel unused = load("newmtl m\nmap_Kd bmp32.png\n");
    EXPECT_TRUE(unused.alpha_masks.empty()) << "nor one that cuts all away, as the fourth byte of many a bitmap does";
    ASSERT_EQ(unused.notes.size(), 1u);
    expect_contains(unused.notes[0], "bmp32.png has an alpha of 0 everywhere: not used");
    EXPECT_EQ(load("newmtl m\nmap_Kd green.png\nd 0\nmap_d mask.tga\n").materials[0].transmission, 0);
}

TEST_F(ObjMaterial, MaterialFilesWithBlanksAndInPlural) {
    write("My Stones.mtl", "newmtl a stone \nKd 1 0 0\n");
    write("b.mtl", "newmtl b\nKd 0 1 0\nnewmtl b\nKd 0 0 1\n");
    const std::string shape = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const SceneModel one =
        load_model(write("one.obj", "mtllib my stones.mtl\n" + shape + "usemtl a stone\t\nf 1 2 3\n"));
    expect_colour(one.materials[one.meshes[0].material].base_colour, {1, 0, 0});
    const SceneModel two =
        load_model(write("two.obj", "mtllib gone.mtl B.MTL\n" + shape + "usemtl b\nf 1 2 3\nmtllib b.mtl\n"));
    expect_colour(two.materials[two.meshes[0].material].base_colour, {0, 1, 0});
    expect_contains(two.notes.at(0), "b.mtl:3: a second material of the name \"b\" is not used");
}

TEST_F(ObjMaterial, NumbersOfATextureTooLargeForFloatsAreLeftOut) {
    save_png("tiles.png");
    const SceneModel model = load("newmtl m\nmap_Kd -s 1e39 1 -o 0 -1e39 tiles.png\n");
    ASSERT_EQ(model.notes.size(), 1u);
    expect_contains(model.notes[0], "m.mtl:2: a number of map_Kd is too large: left out");
    EXPECT_EQ(model.meshes[0].uvs, load("newmtl m\nmap_Kd tiles.png\n").meshes[0].uvs);
}

TEST_F(ObjMaterial, AMaterialFileIsReadOnceHoweverOftenItIsNamed) {
    write("m.mtl", "newmtl m\nKd 1 0 0\nnewmtl n\n");
    std::string names;
    for (int i = 0; i < 1000; ++i)
        names += i % 2 == 0 ? " m.mtl" : " ./M.MTL";
    const SceneModel model = load_model(
        write("model.obj", "mtllib" + names + "\nmtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"));
    EXPECT_EQ(model.materials.size(), 3u) << "m, n and that of faces without one";
    EXPECT_TRUE(model.notes.empty());
}

TEST_F(ObjMaterial, TooManyMaterialsAreRefused) {
    std::string half;
    for (int i = 0; i < 40000; ++i)
        half += "newmtl m\n";
    write("a.mtl", half);
    write("b.mtl", half);
    const auto error = [&](const std::string& names) {
        return input_error([&] { load_model(write("model.obj", "v 0 0 0\nmtllib " + names + "\n")); });
    };
    expect_contains(error("a.mtl b.mtl"), "model.obj:2: expected at most 2^16 materials in all files, found more");
    write("c.mtl", half + half);
    expect_contains(error("c.mtl"), "c.mtl:65537: expected at most 2^16 materials, found more");
}

TEST_F(ObjMaterial, BadStatementsAreNotes) {
    expect_contains(note("Kd red\n"), "m.mtl:2: expected numbers after Kd, found \"red\": not used");
    expect_contains(note("Ns 1e999\n"), "m.mtl:2: expected numbers after Ns");
    expect_contains(note("Ke 1e39 0 0\n"), "m.mtl:2: expected numbers after Ke, found \"1e39 0 0\": not used");
    expect_contains(note("Kd 1e39\nd 0\n"), "m.mtl:2: expected numbers after Kd");
    expect_contains(note("shader x\n"), "m.mtl:2: an unknown statement, shader: not used");
    expect_contains(note("map_Kd -clamp on\n"), "m.mtl:2: map_Kd without a file: not used");
    EXPECT_EQ(load("Kd 1 1 1\nnewmtl m\nKd 0.5\n").notes.size(), 1u) << "a statement before newmtl";
}

TEST_F(ObjMaterial, MaterialFilesAndImagesBelongToTheGeometrysFingerprint) {
    write("m.mtl", "newmtl m\nmap_d Leaf.PNG\n");
    save_png("leaf.png");
    write("model.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
    const auto fingerprint = [&] {
        return load_scene(write("scene.json", R"({"model": "model.obj",
            "camera": {"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]}})"))
            .geometry_fingerprint;
    };
    const std::string before = fingerprint();
    EXPECT_EQ(fingerprint(), before);
    write("leaf.png", png_rgba(1, 1, {0, 0, 0, 0}));
    const std::string other_leaf = fingerprint();
    EXPECT_NE(other_leaf, before);
    write("m.mtl", "newmtl m\n");
    EXPECT_NE(fingerprint(), other_leaf);
}

}  // namespace equistream::test
