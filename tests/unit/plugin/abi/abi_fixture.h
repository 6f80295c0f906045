#pragma once
/// Settings that are right, and a host that answers every tile, for tests of the C ABI.
#include <tests/unit/plugin/export/frame_fixture.h>

#include <equistream/equistream.h>
#include <equistream/sequence.h>

#include <functional>
#include <thread>
#include <vector>

namespace equistream::testing {

inline es_pose pose_of(const Pose& pose) {
    const glm::dvec3& p = pose.position_m;
    const glm::dquat& q = pose.orientation;
    return {{p.x, p.y, p.z}, {q.w, q.x, q.y, q.z}};
}

class AbiTest : public FolderTest {
protected:
    void SetUp() override {
        FolderTest::SetUp();
        output = (folder / "out").string();
        settings.struct_size = sizeof settings;
        settings.abi_version = ES_ABI_VERSION;
        settings.spp = 4;
        settings.seed = 11;
        settings.camera = ES_EQUIRECT;
        settings.width = 72;
        settings.height = 36;
        settings.fov_x_rad = 1.5;
        settings.ipd_m = 0.063;
        settings.frames_per_second = 30;
        settings.exposure = 1;
        settings.output_dir = output.c_str();
        settings.aovs = "all";
        settings.scene_name = "scene";
        settings.host_name = "test host";
        settings.fingerprint = "abc";
    }

    es_sequence* open() {
        es_sequence* sequence = nullptr;
        es_error error{};
        EXPECT_EQ(es_sequence_open(&settings, &sequence, &error), ES_OK) << error.text;
        return sequence;
    }
    /// The one line with which the settings are refused.
    std::string refusal(es_status expected_status = ES_BAD_INPUT) {
        es_sequence* sequence = nullptr;
        es_error error{};
        EXPECT_EQ(es_sequence_open(&settings, &sequence, &error), expected_status);
        EXPECT_EQ(sequence, nullptr);
        return error.text;
    }
    static es_frame_settings at(std::int64_t index, const Pose& previous = {}, const Pose& head = {},
                                const Pose& next = {}) {
        es_frame_settings frame{};
        frame.struct_size = sizeof frame;
        frame.index = index;
        frame.time_s = static_cast<double>(index) / 30;
        frame.head_previous = pose_of(previous);
        frame.head = pose_of(head);
        frame.head_next = pose_of(next);
        return frame;
    }
    static es_frame* begin(es_sequence* sequence, const es_frame_settings& when) {
        es_frame* frame = nullptr;
        es_error error{};
        EXPECT_EQ(es_frame_begin(sequence, &when, &frame, &error), ES_OK) << error.text;
        return frame;
    }
    static void end(es_frame* frame) {
        es_error error{};
        EXPECT_EQ(es_frame_end(frame, &error), ES_OK) << error.text;
    }

    Frame read(std::int64_t index) const { return read_exr(output + "/" + frame_file_name(index)); }

    using Surface = std::function<es_surface(const es_ray&)>;
    using Radiance = std::function<glm::vec4(const es_ray&)>;

    /// Answers every tile of a frame on some threads.
    static void fill(es_frame* frame, const Surface& surface, const Radiance& radiance, int threads = 1) {
        const auto work = [&] {
            es_tile tile{};
            std::vector<es_ray> rays;
            std::vector<es_surface> surfaces;
            std::vector<float> rgba;
            while (es_frame_next_tile(frame, &tile) == ES_OK) {
                rays.resize(tile.pixel_count);
                surfaces.resize(tile.pixel_count);
                rgba.resize(tile.pixel_count * 4);
                std::vector<float> distances(tile.pixel_count);
                while (const std::uint32_t count = es_tile_probe_rays(frame, &tile, rays.data())) {
                    for (std::uint32_t i = 0; i < count; ++i)
                        distances[i] = surface(rays[i]).distance_m;
                    es_tile_put_distances(frame, &tile, distances.data());
                }
                const std::uint32_t pixels = es_tile_geometry_rays(frame, &tile, rays.data());
                for (std::uint32_t i = 0; i < pixels; ++i)
                    surfaces[i] = surface(rays[i]);
                es_tile_put_surfaces(frame, &tile, surfaces.data());
                for (std::uint32_t pass = 0; pass < tile.sample_count; ++pass) {
                    EXPECT_EQ(es_tile_colour_rays(frame, &tile, pass, rays.data()), pixels);
                    for (std::uint32_t i = 0; i < pixels; ++i) {
                        const glm::vec4 colour = radiance(rays[i]);
                        std::copy(&colour.x, &colour.x + 4, &rgba[i * 4]);
                    }
                    es_tile_put_radiance(frame, &tile, rgba.data());
                }
            }
        };
        std::vector<std::jthread> helpers;
        for (int i = 1; i < threads; ++i)
            helpers.emplace_back(work);
        work();
    }
    static es_surface miss(const es_ray&) {
        es_surface surface{};
        surface.distance_m = std::numeric_limits<float>::infinity();
        return surface;
    }
    static glm::vec4 black(const es_ray&) { return {0, 0, 0, 0}; }

    std::string output;
    es_sequence_settings settings{};
};

}  // namespace equistream::testing
