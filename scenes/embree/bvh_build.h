#pragma once
/// An AlphaMask at one bit a texel, 8 x 8 texels to a word: all masks of a scene full of leaves stay in the cache,
/// where the bytes of AlphaMask would not. Internal to Bvh.
#include "bvh.h"

#include <scenes/library/model.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace equistream {

class MaskBits {
public:
    explicit MaskBits(const AlphaMask& mask);

    /// The same as mask.covers(uv); repeating masks, nearly all there are, are answered from the bits.
    bool covers(const glm::vec2& uv) const {
        if (!repeats_)
            return mask_.covers(uv);
        const auto x = static_cast<unsigned>(repeated(uv.x, width_));
        const auto y = static_cast<unsigned>(repeated(uv.y, height_));
        return blocks_[(y >> 3) * blocks_across_ + (x >> 3)] >> ((y & 7u) * 8 + (x & 7u)) & 1u;
    }

private:
    static int repeated(float coordinate, int size) {
        if (!(std::abs(coordinate) < 1e6f))
            return 0;
        float part = coordinate - static_cast<float>(static_cast<int>(coordinate));
        part += part < 0 ? 1.0f : 0.0f;
        return std::min(static_cast<int>(part * static_cast<float>(size)), size - 1);
    }

    const AlphaMask& mask_;
    int width_, height_;
    unsigned blocks_across_;
    bool repeats_;
    std::vector<std::uint64_t> blocks_;
};

// How a SceneModel becomes Embree scenes. Internal to Bvh.

struct DeviceDeleter {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneDeleter {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using DevicePointer = std::unique_ptr<RTCDeviceTy, DeviceDeleter>;
using ScenePointer = std::unique_ptr<RTCSceneTy, SceneDeleter>;

/// A triangle's texture coordinates, together: one cache line a hit instead of four.
struct CornerUvs {
    glm::vec2 a, ab, ac;
};

/// What the filters of one masked geometry read. Must not move once Embree knows its address.
struct MaskedMesh {
    std::vector<CornerUvs> uvs;  ///< by triangle
    const MaskBits* mask;
};

/// A placement either lies in a flat scene in world space, or is an Embree instance of its mesh's own scene.
enum class Placement { flat, instance };

/// Rule, per instance: a mesh placed once and unmoving is flat; so is any placement whose transform is singular, for
/// which Embree's instances have no inverse. Everything else is an instance: flattening that too, tried on san-miguel,
/// makes rays a little faster and the structure several times larger; flattening only small meshes gains nothing.
std::vector<Placement> choose_placements(const SceneModel& model, const std::vector<bool>& moving);

class BvhBuilder {
public:
    BvhBuilder(RTCDevice device, const SceneModel& model, bool ray_filters)
        : device_(device), model_(model), ray_filters_(ray_filters) {}

    ScenePointer new_scene() const;
    void commit(RTCScene scene) const;

    /// Adds the triangles of a mesh, in world space if `world_from_object` is given; returns the geometry's id.
    std::uint32_t add_mesh(RTCScene scene, std::uint32_t mesh, const glm::mat4* world_from_object);
    /// Adds an instance of a committed scene; returns the geometry's id.
    std::uint32_t add_instance(RTCScene scene, RTCScene of, const glm::mat4& world_from_object) const;
    /// The committed scene of one mesh in its own space, built once.
    RTCScene mesh_scene(std::uint32_t mesh);

private:
    const MaskBits& mask_bits(std::uint32_t mask);

    RTCDevice device_;
    const SceneModel& model_;
    bool ray_filters_;
    std::vector<ScenePointer> mesh_scenes_;
    std::vector<std::unique_ptr<MaskedMesh>> masked_;
    std::vector<std::unique_ptr<MaskBits>> mask_bits_;  ///< by alpha mask
};

/// Throws WorkError with Embree's last error, if there is one.
void check_device(RTCDevice device, const char* doing);

}  // namespace equistream
