#pragma once
/// What `equistream COMMAND` runs, and whose options a section [COMMAND] of a settings file may hold.
#include <array>
#include <string_view>

namespace equistream::cli {

struct Command {
    std::string_view name;
    std::string_view program;  ///< beside the dispatcher
    std::string_view summary;
};

inline constexpr std::array commands = {
    Command{"render", "equistream-render-embree", "path trace a scene along a path: EXR sequences with AOVs"},
    Command{"encode", "equistream-encode", "code a rendered sequence as video that carries its poses"},
    Command{"serve", "equistream-serve", "send a recorded stream, or a scene as it is rendered, to viewers"},
    Command{"play", "equistream-play", "decode, reproject to both eyes, fill gaps, write views"},
    Command{"view", "equistream-view", "look around in a stream, in a window"},
    Command{"compare", "equistream-compare", "score views against the truth: PSNR, SSIM, noise-free error"},
    Command{"import", "equistream-import", "make frames of any renderer's EXR sequences"},
    Command{"info", "equistream-info", "explain a stream, a frame or a folder"},
    Command{"model", "equistream-model", "make the geometry a client needs of a scene"},
    Command{"scene", "equistream-scene", "generate bundled scenes, describe a scene"},
    Command{"study", "equistream-study", "speed against accuracy of every method, on real scenes or bundled ones"},
    Command{"fit", "equistream-fit", "the least a scene needs for a wanted accuracy, as a settings file"},
};

}  // namespace equistream::cli
