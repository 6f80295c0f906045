/// What stays of a render that ends early: a host that fails, or is interrupted, at a chosen frame.
#include <host-adapters/common/sequence_renderer.h>

#include <tests/unit/plugin/abi/abi_fixture.h>

#include <equistream/error.h>

#include <nlohmann/json.hpp>

namespace equistream::render_command {
namespace {

class ChosenHost : public RenderHost {
public:
    HostText text() const override { return {}; }
    void add_options(cli::CommandLine&) override {}
    const SceneDescription& describe(const RenderOptions&) override { return scene; }
    void load(const RenderOptions&, const Timeline&) override {}
    HostRecord record() const override { return {"chosen host", ""}; }
    void move_to(const FrameTimes& times) override { on_move(times.index); }
    void cast(std::span<const es_ray>, std::span<float>) override {}
    void render(const FrameTask& task) override { on_render(task); }
    HostFigures figures(double, nlohmann::json&) const override { return {}; }

    SceneDescription scene;
    std::function<void(std::int64_t)> on_move = [](std::int64_t) {};
    std::function<void(const FrameTask&)> on_render;
};

class SequenceRendererTest : public testing::AbiTest {
protected:
    void SetUp() override {
        AbiTest::SetUp();
        host_.scene.camera_path = PosePath({{0, {}}}, "test");
        host_.on_render = [](const FrameTask& task) { finish(task); };
    }
    static void finish(const FrameTask& task) { fill(task.frame, miss, black); }

    /// What a render of frames 0 to 4 ends with; empty: all of them.
    std::string end_of_render() {
        RenderOptions options;
        options.out = output;
        options.size = {32, 16};
        options.spp = 2;
        options.threads = 1;
        options.aovs = "none";
        options.progress = cli::ProgressStyle::none;
        Timeline timeline;
        timeline.path = host_.scene.camera_path;
        timeline.path_frames = 5;
        timeline.range = {0, 4};
        const std::vector<Stream> streams =
            StreamOpener(options, host_.scene, timeline.path, {host_.record(), 0, "test", {}}).all();
        RenderReport report;
        try {
            SequenceRenderer({options, timeline, 0, streams, interrupted_}, host_, report).run();
        } catch (const std::exception& error) {
            return error.what();
        }
        return "";
    }
    std::vector<std::int64_t> frames() const { return list_frames(output + "/centre"); }

    ChosenHost host_;
    std::atomic<bool> interrupted_ = false;
};

using Frames = std::vector<std::int64_t>;

TEST_F(SequenceRendererTest, TheFrameBeforeAFailureIsKept) {
    host_.on_move = [](std::int64_t index) {
        if (index == 3)
            throw WorkError("the host has failed");
    };
    EXPECT_EQ(end_of_render(), "the host has failed");
    EXPECT_EQ(frames(), (Frames{0, 1, 2}));
    host_.on_move = [](std::int64_t) {};
    EXPECT_EQ(end_of_render(), "");
    EXPECT_EQ(frames(), (Frames{0, 1, 2, 3, 4}));
}

TEST_F(SequenceRendererTest, AFrameWhoseLastTileWasDoneIsKeptWhenARenderIsInterrupted) {
    host_.on_render = [this](const FrameTask& task) {
        finish(task);
        interrupted_ = task.index == 1;
    };
    EXPECT_EQ(end_of_render(), "interrupted: 2 of 5 frames are finished; the same command goes on there");
    EXPECT_EQ(frames(), (Frames{0, 1}));
}

TEST_F(SequenceRendererTest, AnInterruptAfterTheLastTileOfAllIsNoFailure) {
    host_.on_render = [this](const FrameTask& task) {
        finish(task);
        interrupted_ = task.index == 4;
    };
    EXPECT_EQ(end_of_render(), "");
    EXPECT_EQ(frames(), (Frames{0, 1, 2, 3, 4}));
}

TEST_F(SequenceRendererTest, AnUnfinishedFrameIsNot) {
    host_.on_render = [this](const FrameTask& task) {
        interrupted_ = task.index == 1;
        if (!interrupted_)
            finish(task);
    };
    EXPECT_EQ(end_of_render(), "interrupted: 1 of 5 frames are finished; the same command goes on there");
    EXPECT_EQ(frames(), Frames{0});
}

}  // namespace
}  // namespace equistream::render_command
