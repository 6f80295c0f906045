#pragma once
/// Scenes that figures are taken on: loaded at the first use, kept to the end.
#include <equistream/stream.h>

#include <client/depth/ray_depth.h>
#include <scenes/embree/bvh.h>
#include <scenes/library/scene.h>

#include <unistd.h>

#include <filesystem>
#include <optional>
#include <string>

namespace equistream::bench {

/// A scene as the client has it, and Embree on the same geometry for peers.
struct BenchScene {
    explicit BenchScene(const SceneDescription& scene);

    SceneDescription description;
    RayDepth depth;
    SceneModel model;
    SceneModel model_without_masks;
    Bvh bvh;
    Bvh bvh_without_masks;
};

/// The bundled scene, or one of EQUISTREAM_SCENES; none where that is not set.
std::optional<SceneDescription> bench_description(const std::string& name);
/// Of it; null where there is none.
BenchScene* bench_scene(const std::string& name);

// A stream of spheres as a file, removed at exit.

/// Values of `make_picture(index)` are 8-bit RGB pictures of the camera's size.
class CodedSphere {
public:
    template <typename MakePicture>
    CodedSphere(const EquirectCamera& camera, int pictures, const std::string& preset, const MakePicture& make_picture)
        : file_(std::filesystem::temp_directory_path() /
                ("equistream-bench-" + std::to_string(getpid()) + "-" + std::to_string(camera.width) + ".mp4")) {
        StreamSettings settings;
        settings.preset = preset;
        settings.tracks = {{TrackRole::main, camera.width, camera.height}};
        settings.pictures = static_cast<std::uint32_t>(pictures);
        StreamWriter writer(file_.string(), settings);
        for (int i = 0; i < pictures; ++i) {
            FrameInfo info;
            info.index = i;
            info.camera = camera;
            const ByteImage picture = make_picture(i);
            writer.write(TrackRole::main, picture.view(), info);
        }
        writer.finish();
    }
    ~CodedSphere() { std::filesystem::remove(file_); }
    CodedSphere(const CodedSphere&) = delete;
    CodedSphere& operator=(const CodedSphere&) = delete;
    std::string name() const { return file_.string(); }

private:
    std::filesystem::path file_;
};

}  // namespace equistream::bench
