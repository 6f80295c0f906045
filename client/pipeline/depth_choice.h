#pragma once
/// Which engine and whose depth eyes are made by, from what was asked for and what there is (docs/guide/play.md, "Which
/// method").
#include <client/warp/engine.h>
#include <equistream/depth_code_info.h>
#include <equistream/frame.h>
#include <scenes/library/scene.h>

#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// What was asked for.
struct DepthWish {
    std::string source;  ///< file, URL or folder; named in messages
    std::string method;  ///< empty: by what depth there is; auto stays auto
    std::string depth;   ///< empty: the first there is of ray and what came
};

/// What there is to take depth from.
struct DepthOffer {
    bool scene = false;                      ///< geometry to find depth in, by rays or by OpenGL
    bool folder = false;                     ///< the source is a folder of rendered frames, not a stream
    bool posed = true;                       ///< ordinary video has no poses, so that no depth fits it
    bool plane = false;                      ///< depth of the main picture came with it
    std::optional<DepthCodeId> code{};       ///< that plane's, in a stream
    std::optional<Eye> eye_without_plane{};  ///< whose very view no depth came of, the first such eye
};

struct DepthChoice {
    std::string method;  ///< never empty; auto stays auto
    std::string depth;   ///< of is_cast, stream, exact or none
    std::vector<std::string> notes;
};

/// Messages name options of programs (--depth). Throws InputError for a depth that this source does not have, and for a
/// method that needs one that is not there.
DepthChoice choose_depth(const DepthWish& wish, const DepthOffer& offer);

/// Throws InputError where the frames of `source` were rendered from another scene than `file`'s, or other geometry.
/// Nothing, or a note where the frames do not name their geometry.
std::optional<std::string> require_same_scene(const FrameInfo& first, const std::string& source,
                                              const SceneDescription& scene, const std::string& file);

}  // namespace equistream
