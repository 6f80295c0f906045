#pragma once
/// Depth by casting rays into the scene's own geometry with Embree (equistream_client_ray). Alpha masks are respected
/// and moving objects are where they are at the time that was set.
#include "depth_source.h"

#include <equistream/camera.h>

#include <scenes/library/scene.h>

#include <memory>
#include <vector>

namespace equistream {

class RayDepth : public DepthSource {
public:
    /// Loads the scene's model without shading data and builds the BVH; throws InputError as load_model does.
    explicit RayDepth(const SceneDescription& scene);
    ~RayDepth() override;

    std::string_view name() const override { return "ray"; }
    void set_time(double time_s) override;
    void cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) override;
    bool cast_patches(const PatchAtlas& atlas, const Pose& pose, ImageView<float> depth_m) override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

// Directions of a view's pixel-centre rays in the world, in single precision: what the ray caster fills packets with.
// An equirect image's come from one table a row and one a column, a perspective view's are linear in the pixel: no
// trigonometry and no double a pixel. Equal to Camera::direction within 2e-7. Concurrent reads are safe.

/// The side of the square of pixels whose rays make a packet of 16: more coherent than a row.
inline constexpr int packet_side = 4;
inline constexpr int packet_size = packet_side * packet_side;

struct DirectionPacket {
    alignas(64) float x[packet_size], y[packet_size], z[packet_size];
};

class RayDirections {
public:
    RayDirections(const Camera& camera, const glm::dquat& orientation);

    /// Of the pixels of a square, row by row, from its first pixel; pixels beyond the picture's edge repeat the last.
    void square(int x, int y, DirectionPacket& out) const;

private:
    void write(int lane, int x, int y, DirectionPacket& out) const;

    /// Equirect: direction = row_cos (sin l a - cos l c) + row_sin b, axes being the camera's in the world.
    /// Perspective: direction = across[x] + down[y], then normalised.
    struct Vectors {
        std::vector<float> x, y, z;
    };
    void set(Vectors& vectors, std::size_t i, const glm::dvec3& v) const;

    bool equirect_;
    Vectors column_, row_;
    std::vector<float> row_cos_;
};

}  // namespace equistream
