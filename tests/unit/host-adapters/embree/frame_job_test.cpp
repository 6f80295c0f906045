/// The host's threads over one frame, against a plugin that hands out as many tiles as it likes and may fail then.
#include "test_scene.h"

#include <host-adapters/embree/program/frame_job.h>

#include <equistream/error.h>

#include <gtest/gtest.h>

namespace {

struct FakePlugin {
    std::atomic<int> tiles_left = 0;
    es_status after_the_last = ES_DONE;
    std::atomic<int> radiance_calls = 0;
};
FakePlugin plugin;

std::uint32_t look_down(const es_tile& tile, es_ray* rays) {
    for (std::uint32_t i = 0; i < tile.pixel_count; ++i)
        rays[i] = equistream::embree_host::make_ray({0, 1, 0}, {0, -1, 0}, i + 1);
    return tile.pixel_count;
}

}  // namespace

extern "C" {

es_status es_frame_next_tile(es_frame*, es_tile* tile) {
    if (plugin.tiles_left.fetch_sub(1) <= 0)
        return plugin.after_the_last;
    *tile = {};
    tile->width = 4;
    tile->height = 1;
    tile->pixel_count = 4;
    tile->sample_count = 2;
    return ES_OK;
}
std::uint32_t es_tile_probe_rays(es_frame*, const es_tile*, es_ray*) {
    return 0;
}
void es_tile_put_distances(es_frame*, const es_tile*, const float*) {}
std::uint32_t es_tile_geometry_rays(const es_frame*, const es_tile* tile, es_ray* rays) {
    return look_down(*tile, rays);
}
std::uint32_t es_tile_colour_rays(const es_frame*, const es_tile* tile, std::uint32_t, es_ray* rays) {
    return look_down(*tile, rays);
}
void es_tile_put_surfaces(es_frame*, const es_tile*, const es_surface*) {}
void es_tile_put_radiance(es_frame*, const es_tile*, const float*) {
    ++plugin.radiance_calls;
}
void es_tile_put_guides(es_frame*, const es_tile*, const float*) {}
void es_tile_put_ids(es_frame*, const es_tile*, const uint32_t*) {}

}  // extern "C"

namespace equistream::embree_host {
namespace {

class FrameJobTest : public ::testing::Test {
protected:
    FrameJobTest() {
        scene.add(floor_mesh(1, 1, 0));
        job.scene = &scene.build();
        job.neighbours.moves = still;
        job.threads = 2;
        job.stop = &stop;
        job.paths_traced = [this](std::uint64_t more) { paths += more; };
    }
    void hand_out(int tiles, es_status then) {
        plugin.tiles_left = tiles;
        plugin.after_the_last = then;
        plugin.radiance_calls = 0;
    }

    TestScene scene;
    const std::vector<std::uint8_t> still{0};  // by instance
    FrameJob job;
    std::atomic<bool> stop = false;
    std::atomic<std::uint64_t> paths = 0;
};

TEST_F(FrameJobTest, DoesEveryTile) {
    hand_out(5, ES_DONE);
    EXPECT_EQ(run_frame(job).paths, 5u * 4 * 2);
    EXPECT_EQ(paths, 5u * 4 * 2);
    EXPECT_EQ(plugin.radiance_calls, 5 * 2);
}

TEST_F(FrameJobTest, APluginThatFailsIsNotTakenForOneThatIsDone) {
    for (const es_status failure : {ES_FAILED, ES_BAD_INPUT}) {
        hand_out(3, failure);
        try {
            run_frame(job);
            ADD_FAILURE() << "status " << failure << " was taken for the end";
        } catch (const WorkError& error) {
            EXPECT_NE(std::string(error.what()).find("next tile"), std::string::npos) << error.what();
        }
    }
}

TEST_F(FrameJobTest, StopsAfterTheTileAtHand) {
    hand_out(1000000, ES_DONE);
    job.threads = 1;
    job.paths_traced = [this](std::uint64_t) { stop = true; };
    EXPECT_EQ(run_frame(job).paths, 4u * 2);
}

}  // namespace
}  // namespace equistream::embree_host
