#pragma once
/// A refresh of the display: what both eyes see of the frame that came last, from wherever they are now. Depth by the
/// scene's geometry, engine, gaps and reliability, all on the GPU; shaders are compiled when it is made, storage
/// there grows with what is asked for and is kept. The context it was made in is current in every call.
#include "frame_textures.h"
#include "stage_times.h"

#include <depth/gl/depth_pass.h>
#include <depth/gl/sphere_depth.h>
#include <fill/gl/gap_look_up.h>
#include <fill/gl/push_pull.h>
#include <reliability/gl/reliability_map.h>
#include <reproject/gl/eye_targets.h>
#include <reproject/gl/look_up.h>

#include <equistream_scene/scene.h>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace equistream::gl {

/// How a refresh is drawn.
struct RefreshOptions {
    bool surface = true;  ///< by depth where there is some, else by direction alone
    bool fill = true;
    bool reliability = false;
};

class EyeRenderer {
public:
    /// Without a scene eyes only turn. `box_radius_m` sizes what depth may be off by.
    EyeRenderer(const SceneDescription* scene, double box_radius_m);
    ~EyeRenderer();

    /// From now on this frame is shown; the one before it stays for gaps.
    void show(std::shared_ptr<const ReceivedFrame> frame, StageTimes& times);

    /// How HDR frames come to the display; before the first one. Null is no display.
    void show_pq_by(std::shared_ptr<PqDisplay> display);
    /// The same frames by another exposure; nothing where they are not HDR.
    void set_exposure(double stops);

    /// Where the eyes are now; all have one size. Only after a frame was shown.
    void look(std::span<const EyeView> eyes, bool by_depth, StageTimes& times);
    /// Draws what they see.
    void draw(const RefreshOptions& options, EyeTargets& targets, StageTimes& times);

    bool has_geometry() const { return geometry_ != nullptr; }
    /// Whether eyes that moved see more than the sphere turned.
    bool has_depth() const { return has_geometry() && frames_[current_].frame() != nullptr && frame().posed; }
    const ReceivedFrame& frame() const { return *frames_[current_].frame(); }
    const SourceTextures& source() const { return frames_[current_].main().textures; }
    /// Of the eyes; texture 0: not known.
    EyeDepth depth() const;
    GLuint reliability() const { return reliability_.texture(); }

private:
    struct Geometry;

    FrameTextures& current() { return frames_[current_]; }
    /// The frame shown before; null: there is none that gaps may be filled from.
    const FrameTextures* earlier() const;
    void find_depth();
    void fill(const EyeDepth& depth, const EyeTargets& targets);

    std::unique_ptr<Geometry> geometry_;
    std::shared_ptr<PqDisplay> pq_display_;
    std::array<FrameTextures, 2> frames_;
    std::size_t current_ = 0;
    std::vector<EyeView> eyes_;
    bool by_depth_ = false;  ///< whether theirs was found
    LookUp turn_, surface_;
    GapTiles gaps_;
    GapLookUp gap_look_up_;
    PatchLookUp patch_look_up_;
    PushPull push_pull_;
    ReliabilityMap reliability_;
};

}  // namespace equistream::gl
