// The property that motion is for: sampling frame N-1 at x + backward(x) gives frame N wherever it was visible, and
// frame N+1 at x + forward(x) likewise. Rendered through the C ABI and read back from the files, with a moving and
// turning head, moving and spinning objects, objects across the seam and at both poles.
#include "abi_fixture.h"
#include "analytic_scene.h"

namespace equistream::testing {
namespace {

constexpr int middle_frame = 4;

Pose head_at(std::int64_t frame) {
    const double f = static_cast<double>(frame);
    const glm::dquat yaw = glm::angleAxis(0.15 * f, glm::dvec3(0, 1, 0));
    const glm::dquat pitch = glm::angleAxis(0.04 * f, glm::dvec3(1, 0, 0));
    return {{0.05 * f, 0.03 * f, -0.06 * f}, yaw * pitch};
}

/// Bilinear, across the seam, and over the poles where the image is a full sphere.
glm::dvec3 sampled(const FloatImage& image, bool is_sphere, glm::dvec2 at) {
    const auto texel = [&](int x, int y) {
        if (is_sphere && (y < 0 || y >= image.height())) {
            y = y < 0 ? -1 - y : 2 * image.height() - 1 - y;
            x += image.width() / 2;
        }
        x = is_sphere ? (x % image.width() + image.width()) % image.width() : std::clamp(x, 0, image.width() - 1);
        const float* p = image.pixel(x, std::clamp(y, 0, image.height() - 1));
        return glm::dvec3(p[0], p[1], p[2]);
    };
    const glm::dvec2 corner = glm::floor(at - 0.5);
    const glm::dvec2 part = at - 0.5 - corner;
    const int x = static_cast<int>(corner.x);
    const int y = static_cast<int>(corner.y);
    return glm::mix(glm::mix(texel(x, y), texel(x + 1, y), part.x),
                    glm::mix(texel(x, y + 1), texel(x + 1, y + 1), part.x), part.y);
}

struct Tally {
    int visible = 0, hidden = 0, across_seam = 0, polar = 0, on_objects = 0;
    double worst_point_m = 0, worst_colour = 0, squared_colour = 0, squared_colour_without = 0;
    int coloured = 0;
};

class MotionProperty : public AbiTest {
protected:
    void render(std::int64_t index) {
        es_sequence* sequence = open();
        es_frame* frame = begin(sequence, at(index, head_at(index - 1), head_at(index), head_at(index + 1)));
        fill(
            frame, [&](const es_ray& ray) { return surface(ray, index); }, black, 2);
        end_with_colour(frame, index);
        es_sequence_close(sequence);
    }

    es_surface surface(const es_ray& ray, std::int64_t index) const {
        const auto f = static_cast<double>(index);
        const glm::dvec3 origin(ray.origin[0], ray.origin[1], ray.origin[2]);
        const glm::dvec3 direction(ray.direction[0], ray.direction[1], ray.direction[2]);
        const BallHit hit = scene.trace(origin, glm::normalize(direction), f);
        const glm::dvec3 before = scene.world(hit, f - 1);
        const glm::dvec3 after = scene.world(hit, f + 1);
        es_surface s{};
        s.distance_m = static_cast<float>(hit.distance_m);
        for (int c = 0; c < 3; ++c) {
            s.position_previous_m[c] = static_cast<float>(before[c]);
            s.position_next_m[c] = static_cast<float>(after[c]);
        }
        s.object_id = static_cast<std::uint32_t>(hit.ball + 1);
        return s;
    }

    /// Colour is handed over as a plane: the texture at pixel centres, unfiltered.
    void end_with_colour(es_frame* frame, std::int64_t index) {
        const Camera camera = this->camera();
        const Pose pose = pose_of_camera(index);
        FloatImage colour(settings.width, settings.height, 4, 1.0f);
        for (int y = 0; y < settings.height; ++y)
            for (int x = 0; x < settings.width; ++x) {
                const glm::dvec3 d = pose.orientation * direction_of(camera, x + 0.5, y + 0.5);
                const glm::dvec3 rgb =
                    AnalyticScene::colour(scene.trace(pose.position_m, d, static_cast<double>(index)));
                for (int c = 0; c < 3; ++c)
                    colour.pixel(x, y)[c] = static_cast<float>(rgb[c]);
            }
        const es_plane plane{
            sizeof plane, "colour", ES_FLOAT32, 4, colour.pixel(0, 0), static_cast<std::size_t>(settings.width) * 16};
        EXPECT_EQ(es_frame_put_plane(frame, &plane, nullptr), ES_OK);
        end(frame);
    }

    Camera camera() const {
        if (settings.camera == ES_PERSPECTIVE)
            return PerspectiveCamera{settings.width, settings.height, settings.fov_x_rad};
        return EquirectCamera{settings.width, settings.height, {}};
    }
    Pose pose_of_camera(std::int64_t index) const {
        return camera_pose(camera(), head_at(index), static_cast<Eye>(settings.eye), settings.ipd_m,
                           static_cast<AxisLock>(settings.lock));
    }
    bool inside(glm::dvec2 p) const { return p.x > 0 && p.y > 0 && p.x < settings.width && p.y < settings.height; }

    /// Follows one motion plane of the middle frame into the frame `step` away and compares.
    Tally follow(const char* plane, int step) {
        const Frame here = read_exr(output + "/" + frame_file_name(middle_frame));
        const Frame there = read_exr(output + "/" + frame_file_name(middle_frame + step));
        const Pose pose_here = pose_of_camera(middle_frame);
        const Pose pose_there = pose_of_camera(middle_frame + step);
        const double f_there = middle_frame + step;
        const bool is_sphere = settings.camera == ES_EQUIRECT;
        Tally tally;
        for (int y = 0; y < settings.height; ++y)
            for (int x = 0; x < settings.width; ++x) {
                const glm::dvec2 pixel(x + 0.5, y + 0.5);
                const float* motion = here.planes.at(plane).pixel(x, y);
                EXPECT_TRUE(std::isfinite(motion[0]) && std::isfinite(motion[1]));
                const glm::dvec2 target = pixel + glm::dvec2(motion[0], motion[1]);
                const glm::dvec3 d = pose_here.orientation * direction_of(camera(), pixel.x, pixel.y);
                const BallHit hit = scene.trace(pose_here.position_m, d, middle_frame);
                EXPECT_NEAR(here.planes.at("depth").pixel(x, y)[0], hit.distance_m, 1e-4);
                // Visible there? Asked of the scene, not of the motion.
                const glm::dvec3 to = scene.world(hit, f_there) - pose_there.position_m;
                const BallHit seen = scene.trace(pose_there.position_m, glm::normalize(to), f_there);
                const bool in_view =
                    is_sphere || inside(pixel_of(camera(), glm::conjugate(pose_there.orientation) * to));
                if (!in_view || std::abs(seen.distance_m - glm::length(to)) > 1e-6) {
                    ++tally.hidden;
                    continue;
                }
                ++tally.visible;
                tally.across_seam += is_sphere && (target.x < 0 || target.x >= settings.width);
                tally.polar += y < 3 || y >= settings.height - 3;
                tally.on_objects += hit.ball > 0;
                // The very point: what the other camera sees in the direction that the motion leads to.
                const glm::dvec3 led = pose_there.orientation * direction_of(camera(), target.x, target.y);
                const glm::dvec3 point = pose_there.position_m + glm::length(to) * led;
                tally.worst_point_m =
                    std::max(tally.worst_point_m, glm::distance(point, scene.world(hit, f_there)) / glm::length(to));
                compare_colour(here, there, pixel, target, tally);
            }
        return tally;
    }

    /// Where all four texels around the target belong to the same object, seen not too flatly.
    void compare_colour(const Frame& here, const Frame& there, glm::dvec2 pixel, glm::dvec2 target, Tally& tally) {
        const bool is_sphere = settings.camera == ES_EQUIRECT;
        const int x = static_cast<int>(pixel.x);
        const int y = static_cast<int>(pixel.y);
        const IdImage& ids = there.ids.at("object_id");
        for (const glm::dvec2 corner :
             {glm::dvec2(-1.5, -1.5), glm::dvec2(1.5, -1.5), glm::dvec2(-1.5, 1.5), glm::dvec2(1.5, 1.5)}) {
            const glm::ivec2 at = glm::ivec2(glm::floor(target + corner));
            const int column = is_sphere ? (at.x % settings.width + settings.width) % settings.width
                                         : std::clamp(at.x, 0, settings.width - 1);
            if (*ids.pixel(column, std::clamp(at.y, 0, settings.height - 1)) != *here.ids.at("object_id").pixel(x, y))
                return;
        }
        const float* p = here.planes.at("colour").pixel(x, y);
        const glm::dvec3 wanted(p[0], p[1], p[2]);
        const glm::dvec3 found = sampled(there.planes.at("colour"), is_sphere, target);
        const glm::dvec3 without = sampled(there.planes.at("colour"), is_sphere, pixel);
        tally.worst_colour = std::max(tally.worst_colour, glm::length(found - wanted));
        tally.squared_colour += glm::dot(found - wanted, found - wanted);
        tally.squared_colour_without += glm::dot(without - wanted, without - wanted);
        ++tally.coloured;
    }

    void expect_property() {
        settings.aovs = "depth,motion,ids";
        settings.spp = 1;
        for (int step = -1; step <= 1; ++step)
            render(middle_frame + step);
        for (const auto& [plane, step] : {std::pair{"backward", -1}, {"forward", 1}}) {
            SCOPED_TRACE(plane);
            const Tally tally = follow(plane, step);
            EXPECT_GT(tally.visible, settings.width * settings.height * 7 / 10);
            EXPECT_GT(tally.hidden, 0);
            EXPECT_GT(tally.on_objects, 200);
            if (settings.camera == ES_EQUIRECT) {
                EXPECT_GT(tally.across_seam, 10);
                EXPECT_GT(tally.polar, settings.width);
            }
            // Positions travel as floats: a few 1e-7 of the distance.
            EXPECT_LT(tally.worst_point_m, 3e-6);
            EXPECT_GT(tally.coloured, tally.visible / 2);
            const double rms = std::sqrt(tally.squared_colour / tally.coloured);
            const double rms_without = std::sqrt(tally.squared_colour_without / tally.coloured);
            EXPECT_LT(tally.worst_colour, 0.05);
            EXPECT_LT(rms, 0.003);
            EXPECT_GT(rms_without, 20 * rms) << "without motion the same comparison must fail";
        }
    }

    AnalyticScene scene;
};

TEST_F(MotionProperty, world_locked_sphere_at_the_left_eye_of_a_turning_head) {
    settings.width = 256;
    settings.height = 128;
    settings.eye = ES_EYE_LEFT;
    settings.ipd_m = 0.3;
    expect_property();
}

TEST_F(MotionProperty, path_locked_sphere) {
    settings.width = 256;
    settings.height = 128;
    settings.lock = ES_LOCK_PATH;
    expect_property();
}

TEST_F(MotionProperty, perspective_at_the_right_eye) {
    settings.width = 200;
    settings.height = 150;
    settings.camera = ES_PERSPECTIVE;
    settings.eye = ES_EYE_RIGHT;
    expect_property();
}

TEST_F(MotionProperty, misses_move_by_rotation_only) {
    settings.lock = ES_LOCK_PATH;
    settings.aovs = "motion";
    settings.spp = 1;
    es_sequence* sequence = open();
    es_frame* frame = begin(sequence, at(1, head_at(0), head_at(1), head_at(2)));
    fill(frame, miss, black);
    end(frame);
    es_sequence_close(sequence);
    const Frame read = read_exr(output + "/frame.0001.exr");
    const EquirectCamera sphere{settings.width, settings.height, {}};
    for (int y = 0; y < settings.height; ++y)
        for (int x = 0; x < settings.width; ++x) {
            const float* motion = read.planes.at("backward").pixel(x, y);
            const glm::dvec3 led = head_at(0).orientation * sphere.direction(x + 0.5 + motion[0], y + 0.5 + motion[1]);
            const glm::dvec3 here = head_at(1).orientation * sphere.direction(x + 0.5, y + 0.5);
            ASSERT_LT(glm::distance(led, here), 1e-6);
        }
}

}  // namespace
}  // namespace equistream::testing
