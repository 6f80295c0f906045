#pragma once
/// Which patches to render (equistream/patches.h): those blocks of auxiliary spheres that show most of what eyes in the
/// head box see and the sphere's centre does not.
///
/// Eyes are tried at places spread over the ball. A point that such an eye sees is a *gap sample* if the centre does
/// not see it, by the client's own rule (depth_agreement.h), and it counts by the solid angle it takes in the eye. A
/// block covers the gap samples that its auxiliary sphere sees within it. Blocks are chosen greedily, the one that
/// covers most of what is still uncovered first: coverage is submodular, so this is within 1 - 1/e of the best choice
/// (Nemhauser, Wolsey and Fisher 1978), and as coverage only shrinks, stale gains are upper bounds (Minoux 1978).
#include <equistream/bound.h>
#include <equistream/patches.h>

#include <functional>
#include <vector>

namespace equistream {

/// Radial depth from `offset_m` from the sphere's centre, in the sphere camera's axes, at each pixel of `camera`, whose
/// size `depth_m` has: +inf for a miss. Called by one thread.
using CastSphere =
    std::function<void(const glm::dvec3& offset_m, const EquirectCamera& camera, ImageView<float> depth_m)>;

struct PatchSettings {
    EquirectCamera sphere;
    double box_radius_m = 0;              ///< every eye stays within this of the sphere's centre (bound.h); above 0
    double budget = 0.1;                  ///< most pixels of the atlas, as a share of the sphere's
    int block_side = 8;                   ///< pixels
    int training_eyes = 128;              ///< places in the ball that gap samples are taken from
    int stride = 2;                       ///< of the training eyes' pixels every so many columns and rows are samples
    double hysteresis = 0.25;             ///< by so much better must a new block be than one that has its slot already
    std::vector<glm::dvec3> offsets_m{};  ///< of the auxiliary spheres; empty: patch_offsets
    double tolerance_rad = error_budget_rad(default_focal_length_px);  ///< of depth_agreement.h
};

/// The least side, a multiple of 4 so that blocks fit those of video codecs, whose slots hold the budget: small blocks
/// show more for as many pixels, but an atlas has at most max_patch_slots of them.
int finest_patch_side(const EquirectCamera& sphere, double budget);

/// How a plan came out. Shares are of the gap samples' weight.
struct PatchFigures {
    double covered = 0;             ///< by the chosen blocks
    double coverable = 0;           ///< by all blocks of all auxiliary spheres together
    double pixel_share = 0;         ///< of used slots, to the sphere's pixels
    std::size_t kept_slots = 0;     ///< as in the frame before
    double cast_s = 0, plan_s = 0;  ///< time in the callback, and in all else
};

struct PatchPlan {
    PatchAtlas atlas;
    PatchFigures figures;
};

/// Auxiliary positions for a ball of this radius, fit for single precision.
std::vector<glm::dvec3> patch_offsets(double box_radius_m);

/// The atlas that every frame of a sequence shares: offsets and slots, all unused. Throws InputError for settings that
/// cannot be met.
PatchAtlas empty_atlas(const PatchSettings& settings);

/// Plans one frame. `previous` is the frame before, if there is one: a block that it has keeps its slot.
PatchPlan plan_patches(const PatchSettings& settings, const CastSphere& cast, const PatchAtlas* previous = nullptr);

}  // namespace equistream
