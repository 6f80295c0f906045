// The paper's scenes, where EQUISTREAM_SCENES says they are.
#include <tests/unit/scenes/ray_tracing.h>
#include <tests/unit/scenes/temporary_folder.h>

#include <scenes/library/scene.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

namespace equistream::test {

namespace {

/// Test names may not have hyphens.
std::string test_name(std::string name) {
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

struct RealScene {
    const char* name;
    std::uint64_t triangles;
};

std::ostream& operator<<(std::ostream& out, const RealScene& scene) {
    return out << scene.name;
}

class RealScenes : public TemporaryFolder, public ::testing::WithParamInterface<RealScene> {
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
    const std::filesystem::path cut = folder_ / "cut.glb";
    std::filesystem::copy_file(file_, cut);
    std::filesystem::permissions(cut, std::filesystem::perms::owner_write, std::filesystem::perm_options::add);
    std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
    expect_contains(input_error([&] { load_model(cut); }), "truncated");
}

/// Normals decoded with a wrong stride, scale or axis order would stand at random to the faces. In san-miguel's file
/// some do (leaves and tablecloths, 17 % of its triangles), in the others hardly any.
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
    EXPECT_GT(static_cast<double>(agree), 0.8 * static_cast<double>(all));
}

INSTANTIATE_TEST_SUITE_P(Paper, RealScenes,
                         ::testing::Values(RealScene{"sponza-crytek", 262267}, RealScene{"san-miguel", 9388826},
                                           // Its README counts 283,256: the sheet below the city has 2 more.
                                           RealScene{"voxel-city", 283258}, RealScene{"kitchen", 1443517},
                                           RealScene{"sibenik", 74292}),
                         [](const auto& scene) { return test_name(scene.param.name); });

namespace {

constexpr int path_frames = 150;

/// A description of this repository with its model and a Bvh to walk in.
class Descriptions : public ::testing::TestWithParam<const char*> {
protected:
    void SetUp() override {
        const char* folder = std::getenv("EQUISTREAM_SCENES");
        if (!folder || !*folder)
            GTEST_SKIP() << "EQUISTREAM_SCENES is not set: descriptions of real scenes are left out";
        scene_ = load_scene(std::filesystem::path(EQUISTREAM_DESCRIPTIONS) / (std::string(GetParam()) + ".json"));
        model_ = load_model(scene_.model, {.shading = false});
        bvh_ = std::make_unique<Bvh>(model_);
    }

    Pose head(int frame) const { return scene_.camera_path.at(frame / scene_.frames_per_second); }

    double clearance(const glm::dvec3& from, const std::vector<glm::vec3>& directions) const {
        double nearest = std::numeric_limits<double>::infinity();
        for (const glm::vec3& direction : directions)
            nearest = std::min(nearest, trace(*bvh_, {glm::vec3(from), direction}).distance);
        return nearest;
    }

    /// Share of the 15 degrees around an eye's view axis that a leaf nearer than 0.6 m takes.
    double leaf_share(const Pose& pose, Eye eye) const {
        std::mt19937 random(6);
        int leaves = 0, all = 0;
        while (all < 400) {
            const glm::vec3 d = random_direction(random);
            if (-d.z < std::cos(glm::radians(15.0f)))
                continue;
            ++all;
            const Hit hit = trace(*bvh_, {glm::vec3(eye_position(pose, eye, default_ipd_m)),
                                          glm::vec3(pose.orientation * glm::dvec3(d))});
            if (hit.id.instance == no_index || hit.distance > 0.6)
                continue;
            const Mesh& mesh = model_.meshes[model_.instances[hit.id.instance].mesh];
            leaves += model_.materials[mesh.material].alpha_mask != no_index;
        }
        return leaves / static_cast<double>(all);
    }

    SceneDescription scene_;
    SceneModel model_;
    std::unique_ptr<Bvh> bvh_;
};

}  // namespace

TEST_P(Descriptions, PathKeepsClearAndPassesClose) {
    std::mt19937 random(4);
    std::vector<glm::vec3> directions;
    for (int i = 0; i < 4096; ++i)
        directions.push_back(random_direction(random));
    std::vector<double> clearances(path_frames);
    tbb::parallel_for(0, path_frames, [&](int frame) {
        clearances[static_cast<std::size_t>(frame)] = clearance(head(frame).position_m, directions);
        // Leaves and chairs may be in between: the floor is looked for below them.
        constexpr double above_floor = 1.4;
        const glm::vec3 low(head(frame).position_m - glm::dvec3(0, above_floor, 0));
        EXPECT_NEAR(above_floor + trace(*bvh_, {low, {0, -1, 0}}).distance, 1.6, 0.05) << "frame " << frame;
    });
    const auto nearest = std::min_element(clearances.begin(), clearances.end());
    EXPECT_GT(*nearest, 0.25) << "in frame " << nearest - clearances.begin();
    EXPECT_LT(*nearest, 1);
}

TEST_P(Descriptions, PathWalksAndTurns) {
    EXPECT_EQ(std::lround(scene_.camera_path.duration_s() * scene_.frames_per_second) + 1, path_frames);
    double widest_turn_deg = 0;
    for (int frame = 1; frame < path_frames; ++frame) {
        const double speed =
            glm::length(head(frame).position_m - head(frame - 1).position_m) * scene_.frames_per_second;
        EXPECT_GT(speed, 0.3) << frame;
        EXPECT_LT(speed, 1.8) << frame;
        const double cosine = std::abs(glm::dot(head(frame).orientation, head(0).orientation));
        widest_turn_deg = std::max(widest_turn_deg, glm::degrees(2 * std::acos(std::min(1.0, cosine))));
    }
    EXPECT_GT(widest_turn_deg, 90);
}

class LeafyDescriptions : public Descriptions {};

TEST_P(LeafyDescriptions, LeafBeforeTheLeftEye) {
    const auto hidden = [&](int first, int last) {
        for (int frame = first; frame <= last; ++frame) {
            const double left = leaf_share(head(frame), Eye::left);
            if (left > 0.3 && leaf_share(head(frame), Eye::right) < 0.6 * left)
                return true;
        }
        return false;
    };
    EXPECT_TRUE(hidden(0, 7));
    EXPECT_FALSE(hidden(12, 24));
    EXPECT_TRUE(hidden(25, 149));
}

INSTANTIATE_TEST_SUITE_P(Paper, Descriptions,
                         ::testing::Values("sponza-crytek", "san-miguel", "kitchen", "sibenik", "voxel-city"),
                         [](const auto& scene) { return test_name(scene.param); });
INSTANTIATE_TEST_SUITE_P(Paper, LeafyDescriptions, ::testing::Values("san-miguel"),
                         [](const auto& scene) { return test_name(scene.param); });

}  // namespace equistream::test
