// The paper's scenes, where EQUISTREAM_SCENES says they are.
#include "ray_tracing.h"
#include "temporary_folder.h"

#include <equistream_scene/scene.h>

#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdlib>

namespace equistream::test {

namespace {

struct RealScene {
    const char* name;
    std::uint64_t triangles;
};

std::ostream& operator<<(std::ostream& out, const RealScene& scene) {
    return out << scene.name;
}

class RealScenes : public ::testing::TestWithParam<RealScene> {
protected:
    void SetUp() override {
        const char* folder = std::getenv("EQUISTREAM_SCENES");
        if (!folder || !*folder)
            GTEST_SKIP() << "EQUISTREAM_SCENES is not set: real scenes are left out";
        file_ = std::filesystem::path(folder) / GetParam().name / (std::string(GetParam().name) + ".glb");
        if (!std::filesystem::exists(file_))
            GTEST_SKIP() << file_ << " is not there";
    }
    std::filesystem::path file_;
};

}  // namespace

TEST_P(RealScenes, LoadsWithTheTrianglesItsReadmeStates) {
    const SceneModel model = load_model(file_);
    EXPECT_EQ(model.triangle_count(), GetParam().triangles);
    for (const Mesh& mesh : model.meshes) {
        EXPECT_FALSE(mesh.normals.empty()) << mesh.name;
        for (const glm::vec3& n : mesh.normals)
            ASSERT_TRUE(std::abs(glm::length(n) - 1) < 1e-5f || n == glm::vec3(0)) << mesh.name;
    }
}

TEST_P(RealScenes, TruncatedIsRefused) {
    const std::filesystem::path cut =
        std::filesystem::temp_directory_path() / (std::string(GetParam().name) + "-cut.glb");
    std::filesystem::copy_file(file_, cut, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::permissions(cut, std::filesystem::perms::owner_write, std::filesystem::perm_options::add);
    std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
    expect_contains(input_error([&] { load_model(cut); }), "truncated");
    std::filesystem::remove(cut);
}

/// Normals decoded with a wrong stride, scale or axis order would stand at random to the faces. In san-miguel's file
/// some do (leaves and tablecloths, 12 % of its triangles), in the others hardly any.
TEST_P(RealScenes, NormalsAgreeWithGeometry) {
    const SceneModel model = load_model(file_);
    std::uint64_t agree = 0, all = 0;
    for (const Mesh& mesh : model.meshes)
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::vec3 geometric =
                glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
            const glm::vec3 shading = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
            if (glm::length(geometric) == 0 || glm::length(shading) < 0.5f)
                continue;
            ++all;
            agree += std::abs(glm::dot(glm::normalize(geometric), glm::normalize(shading))) > 0.5f;
        }
    EXPECT_GT(static_cast<double>(agree), 0.85 * static_cast<double>(all));
}

INSTANTIATE_TEST_SUITE_P(Paper, RealScenes,
                         ::testing::Values(RealScene{"sponza-crytek", 262267}, RealScene{"san-miguel", 9388826},
                                           // Its README counts 283,256: the sheet below the city has 2 more.
                                           RealScene{"voxel-city", 283258}, RealScene{"kitchen", 1443517},
                                           RealScene{"sibenik", 74292}),
                         [](const auto& scene) {
                             std::string name = scene.param.name;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

}  // namespace equistream::test
