/// GLSL's formulas are those of the headers: a million directions and depths through both.
#include "gl_fixture.h"

#include <client/warp/gl/eye_depth_finder.h>
#include <client/warp/gl/source_textures.h>
#include <client/warp/resample.h>
#include <client/warp/source_lattice.h>
#include <tests/unit/client/engine_scenes.h>

#include <equistream/depth_agreement.h>

#include <glm/vec4.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace equistream::test {
namespace {

constexpr int million = 1 << 20, group = 256;

const char* probe = R"glsl(
layout(local_size_x = 256) in;
layout(binding = 1) uniform sampler2D source_depth;
#include "source_grid.glsl"
float depth_around(ivec2 at) { return texelFetch(source_depth, wrapped(at), 0).x; }
#include "depth_agreement.glsl"

struct Query {
    vec4 direction;  // and the point's distance
    vec4 others;     // distances predicted and of a sample, box radius, tolerance
    vec4 at;         // position from the middle of the first sample
};
struct Answer {
    vec4 position;  // and reach, and 1 where it is covered
    vec4 holds;     // agree, lies_between, is_hidden
};
layout(std430, binding = 0) readonly buffer Queries { Query queries[]; };
layout(std430, binding = 1) writeonly buffer Answers { Answer answers[]; };

void main() {
    Query q = queries[gl_GlobalInvocationID.x];
    box_radius_m = q.others.z;
    tolerance = q.others.w;
    vec2 position = position_of(q.direction.xyz);
    float reach = clearance_of(q.direction.w), predicted = clearance_of(q.others.x), of_sample = clearance_of(q.others.y);
    answers[gl_GlobalInvocationID.x] =
        Answer(vec4(position, reach, is_covered(position) ? 1.0 : 0.0),
               vec4(agree(reach, of_sample), lies_between(reach, predicted, of_sample), is_hidden(q.at.xy, q.direction.w), 0.0));
}
)glsl";

const char* directions_probe = R"glsl(
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#include "source_grid.glsl"
layout(std430, binding = 1) writeonly buffer Directions { vec4 directions[]; };

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID);
    if (all(lessThan(at, source_size)))
        directions[at.y * source_size.x + at.x] = vec4(direction_of(at), 0.0);
}
)glsl";

const char* directions_around_probe = R"glsl(
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#include "source_grid.glsl"
layout(std430, binding = 1) buffer Most { uint off_bits, corners; };

void main() {
    ivec2 corner = ivec2(gl_GlobalInvocationID) - 2;
    if (any(greaterThan(corner, source_size)))
        return;
    vec3 directions[4] = directions_around(corner);
    float off = 0.0;
    for (int k = 0; k < 4; ++k)
        off = max(off, distance(directions[k], direction_of(wrapped(corner + ivec2(k & 1, k >> 1)))));
    atomicMax(off_bits, floatBitsToUint(off));
    atomicAdd(corners, 1u);
}
)glsl";

const char* lattice_probe = R"glsl(
layout(local_size_x = GROUP_WIDTH, local_size_y = GROUP_HEIGHT) in;
#include "source_grid.glsl"
#include "source_lattice.glsl"
struct Point {
    vec4 q;  // and k
    uint is_sample, unused0, unused1, unused2;
};
layout(std430, binding = 1) writeonly buffer Points { Point points[]; };

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID), size = source_size + 6, p = at - 3;
    if (all(lessThan(at, size)))
        points[at.y * size.x + at.x] =
            Point(vec4(lattice_direction(p), lattice_inverse(p)), is_sample(p) ? 1u : 0u, 0u, 0u, 0u);
}
)glsl";

struct Query {
    glm::vec4 direction, others, at;
};
struct Answer {
    glm::vec4 position, holds;
};

const std::vector<Camera> cameras = {EquirectCamera{6032, 3016, {}}, EquirectCamera{1200, 700, {-2.4, 2.1, -1.2, 1.3}},
                                     PerspectiveCamera{1920, 1080, 1.8}};

/// Of every direction, at seams and poles too, where the cameras' contract (conventions.h) has it.
class Formulas : public Gl {
protected:
    std::vector<Answer> ask(const gl::SourceTextures& source, std::span<const Query> queries) {
        const gl::Program program({{GL_COMPUTE_SHADER, "probe", probe}});
        const gl::Buffer in = gl::make_buffer_of(queries);
        const gl::Buffer out = gl::make_buffer(queries.size() * sizeof(Answer), 0);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, in.name());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.name());
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
        glBindTextureUnit(1, source.depth());
        program.use();
        glDispatchCompute(GLuint(queries.size() / group), 1, 1);
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        std::vector<Answer> answers(queries.size());
        glGetNamedBufferSubData(out.name(), 0, GLsizeiptr(queries.size() * sizeof(Answer)), answers.data());
        return answers;
    }

    /// Distances near each other and far apart, misses and unknown ones; boxes of up to 30 cm.
    Query random_query() {
        const auto distance = [&](float near) {
            const int kind = int(random() % 16);
            return kind == 0   ? float(infinity)
                   : kind == 1 ? std::nanf("")
                   : kind < 9  ? near * (1 + 1e-3f * float(one(random)))
                               : 0.05f * std::exp2(4 + 4 * float(one(random)));
        };
        Query q;
        const float r = distance(2);
        const double y = one(random), longitude = pi * one(random), across = std::sqrt(1 - y * y);
        q.direction = glm::vec4(glm::vec3(across * std::sin(longitude), y, -across * std::cos(longitude)), r);
        if (random() % 64 == 0)
            q.direction = {0, random() % 2 == 0 ? 1 : -1, 0, r};
        else if (random() % 64 == 0)
            q.direction.x = random() % 2 == 0 ? 0.0f : -0.0f;
        q.others = {distance(r), distance(r), 0.15f + 0.15f * float(one(random)),
                    1e-3f * std::exp2(float(one(random)))};
        return q;
    }

    std::mt19937 random{17};
    std::uniform_real_distribution<double> one{-1, 1};
};

TEST_F(Formulas, DirectionsFallOnThePixelsOfTheContract) {
    std::vector<Query> queries(million);
    for (Query& query : queries)
        query = random_query();
    for (const Camera& camera : cameras) {
        gl::SourceTextures source;
        source.describe(camera);
        const int width = width_of(camera), height = height_of(camera);
        const std::vector<Answer> answers = ask(source, queries);
        double worst_px = 0;
        std::int64_t others = 0;
        for (std::size_t i = 0; i < queries.size(); ++i) {
            const glm::dvec3 d(queries[i].direction);
            const glm::dvec2 is(answers[i].position), at = pixel_of(camera, d);
            const bool in_front = std::holds_alternative<EquirectCamera>(camera) || d.z < 0;
            const double edge = 0.02, slack = 0.005;
            const auto inside = [&](double by) {
                return in_front && at.x >= -by && at.y >= -by && at.x <= width + by && at.y <= height + by;
            };
            const bool covered = answers[i].position.w != 0;
            others += covered ? !inside(edge + slack) : inside(edge - slack);
            if (!inside(0))
                continue;
            double across = std::abs(is.x - at.x);
            if (columns_close(camera))
                across = std::min(across, width - across);
            // At a pole any column is as good.
            worst_px = std::max({worst_px, std::abs(is.y - at.y), across * std::hypot(d.x, d.z)});
        }
        EXPECT_EQ(others, 0) << width;
        // fast_atan2's 4e-7 rad, and single precision of positions up to 6,032.
        EXPECT_LT(worst_px, 3e-3) << width;
    }
}

TEST_F(Formulas, SamplesLookWhereTheContractHasThem) {
    const gl::Program program({{GL_COMPUTE_SHADER, "probe", directions_probe}});
    const std::vector<Camera> of_a_million = {EquirectCamera{1536, 768, {}}, cameras[1], cameras[2]};
    for (const Camera& camera : of_a_million) {
        gl::SourceTextures source;
        source.describe(camera);
        const int width = width_of(camera), height = height_of(camera);
        std::vector<glm::vec4> directions(std::size_t(width) * std::size_t(height));
        const gl::Buffer out = gl::make_buffer(directions.size() * sizeof(glm::vec4), 0);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.name());
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
        program.dispatch({width, height});
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        glGetNamedBufferSubData(out.name(), 0, GLsizeiptr(directions.size() * sizeof(glm::vec4)), directions.data());
        double worst = 0;
        for (std::size_t i = 0; i < directions.size(); ++i) {
            const int x = int(i) % width, y = int(i) / width;
            worst = std::max(worst, glm::distance(direction_of(camera, x + 0.5, y + 0.5), glm::dvec3(directions[i])));
        }
        EXPECT_LT(worst, 2e-6) << width;
    }
}

/// All corners of four samples, those around the edges too.
TEST_F(Formulas, FourSamplesHaveTheirOwnDirections) {
    const gl::Program program({{GL_COMPUTE_SHADER, "directions around", directions_around_probe}});
    for (const Camera& camera : engine_sources(720)) {
        gl::SourceTextures source;
        source.describe(camera);
        std::array<GLuint, 2> most{};
        const gl::Buffer found = gl::make_buffer_of(std::span<const GLuint>(most));
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, found.name());
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
        const gl::Size corners{width_of(camera) + 3, height_of(camera) + 3};
        program.dispatch(corners);
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        glGetNamedBufferSubData(found.name(), 0, sizeof most, most.data());
        EXPECT_LT(std::bit_cast<float>(most[0]), 4e-6f) << width_of(camera);
        EXPECT_EQ(most[1], GLuint(corners.width * corners.height));
    }
}

/// Samples, and points beyond the edges, of every kind of picture; where nothing is known of a sample, nothing is known
/// beside it.
TEST_F(Formulas, LatticesAreThoseOfTheHeaders) {
    const gl::Program program({{GL_COMPUTE_SHADER, "lattice", lattice_probe}});
    struct Point {
        glm::vec4 q;
        std::array<GLuint, 4> is_sample;
    };
    std::vector<Camera> all = engine_sources(96);
    all.push_back(EquirectCamera{64, 20, {-pi, pi, -0.7, 0.8}});
    all.push_back(EquirectCamera{45, 22, {}});
    for (const Camera& camera : all) {
        const int width = width_of(camera), height = height_of(camera);
        FloatImage depth_m(width, height, 1);
        for (float& r : depth_m.samples())
            r = random() % 4 == 0 ? std::nanf("") : random() % 4 == 0 ? float(infinity) : float(3 + one(random));
        const ByteImage rgb(width, height, 3);
        gl::SourceTextures source;
        source.upload({.rgb = rgb.view(), .camera = camera, .depth_m = depth_m.view()});
        gl::LatticeTextures angles;
        angles.set(camera);
        const gl::Size points{width + 6, height + 6};
        std::vector<Point> found(std::size_t(points.width) * std::size_t(points.height));
        const gl::Buffer out = gl::make_buffer(found.size() * sizeof(Point), 0);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.name());
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, source.grid());
        glBindTextureUnit(1, source.depth());
        angles.bind();
        program.dispatch(points);
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        glGetNamedBufferSubData(out.name(), 0, GLsizeiptr(found.size() * sizeof(Point)), found.data());
        const SourceLattice lattice(camera, depth_m.view());
        int others = 0, unknown = 0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            const int x = int(i) % points.width - 3, y = int(i) / points.width - 3;
            const LatticePoint point = lattice.point(x, y);
            const glm::vec4& is = found[i].q;
            const bool same_k = std::isnan(point.k) ? std::isnan(is.w) : std::abs(is.w - point.k) <= 1e-6f;
            const glm::vec3 off = glm::vec3(is) - glm::vec3(point.q.x, point.q.y, point.q.z);
            others += !same_k || glm::length(off) > 1e-6f || (found[i].is_sample[0] != 0) != lattice.is_sample(x, y);
            unknown += std::isnan(point.k);
        }
        EXPECT_EQ(others, 0) << width;
        EXPECT_GT(unknown, 100) << width;
    }
}

/// Where the headers' answer hangs on a rounding, either will do.
TEST_F(Formulas, DepthsAgreeWhereTheHeadersSayIt) {
    gl::SourceTextures source;
    source.describe(cameras[2]);
    source.depth_to_write();
    std::vector<Query> queries(million);
    for (Query& query : queries)
        query = random_query();
    const std::vector<Answer> answers = ask(source, queries);
    std::array<std::int64_t, 2> yes{}, others{};
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const Query& q = queries[i];
        const auto with = [&](float tolerance) {
            const DepthAgreement agreement{q.others.z, tolerance};
            const float reach = agreement.clearance(q.direction.w), of_sample = agreement.clearance(q.others.y);
            return std::array{agreement.same(reach, of_sample),
                              agreement.between(reach, agreement.clearance(q.others.x), of_sample)};
        };
        const float reach = DepthAgreement{q.others.z, 0}.clearance(q.direction.w), found = answers[i].position.z;
        ASSERT_TRUE(std::isnan(reach) ? std::isnan(found) : std::abs(found / reach - 1) < 1e-6f) << q.direction.w;
        const auto expected = with(q.others.w), low = with(q.others.w * 0.999f), high = with(q.others.w * 1.001f);
        for (std::size_t k = 0; k < 2; ++k) {
            yes[k] += expected[k];
            others[k] += low[k] == high[k] && expected[k] != (answers[i].holds[int(k)] != 0);
        }
    }
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(others[k], 0);
        EXPECT_GT(yes[k], million / 20) << "both answers are asked for";
        EXPECT_LT(yes[k], million * 19 / 20);
    }
}

TEST_F(Formulas, SmoothSurfacesHideWhatTheHeadersSay) {
    const EquirectCamera camera{512, 256, {}};
    // Waves, a step, and a hole.
    FloatImage depth_m(512, 256, 1);
    for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 512; ++x)
            *depth_m.pixel(x, y) =
                float(2 + 0.5 * std::sin(0.05 * x * 2 * pi / 3.2) + 0.4 * std::cos(0.08 * y) + (x > 300 ? 1 : 0));
    *depth_m.pixel(100, 100) = std::nanf("");
    const ByteImage rgb(512, 256, 3);
    gl::SourceTextures source;
    source.upload({.rgb = rgb.view(), .camera = camera, .depth_m = depth_m.view()});
    const SourceGrid grid = source_grid(camera);
    std::vector<Query> queries(million);
    std::vector<glm::ivec2> at(million);
    for (std::size_t i = 0; i < queries.size(); ++i) {
        at[i] = {int(random() % (512 * position_one)), int(random() % (256 * position_one)) - position_one / 2};
        queries[i].at = glm::vec4(glm::vec2(at[i]) / float(position_one), 0, 0);
        const Sample sample = wrapped(grid, at[i].x >> position_bits, at[i].y >> position_bits);
        const float surface_m = *depth_m.pixel(sample.x, sample.y);
        queries[i].direction = {0, 0, -1, surface_m * (1 + 0.3f * float(one(random)))};
        // So that second differences and what a point lies behind are now below what counts, now above.
        queries[i].others = {0, 0, 0.1f, 1e-3f * std::exp2(-4 + 4 * float(one(random)))};
    }
    const std::vector<Answer> answers = ask(source, queries);
    std::int64_t yes = 0, others = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const auto with = [&](float tolerance) {
            const DepthAgreement agreement{queries[i].others.z, tolerance};
            return surface_hides(agreement, grid, depth_m.view(), at[i].x, at[i].y,
                                 1 / agreement.clearance(queries[i].direction.w));
        };
        const float tolerance = queries[i].others.w;
        const bool expected = with(tolerance);
        yes += expected;
        // Tolerances are what second differences may be, and what a point must be behind.
        if (expected != (answers[i].holds.z != 0))
            others += with(0.999f * tolerance) == with(1.001f * tolerance);
    }
    EXPECT_EQ(others, 0);
    EXPECT_GT(yes, million / 50);
    EXPECT_LT(yes, million * 49 / 50);
}

}  // namespace
}  // namespace equistream::test
