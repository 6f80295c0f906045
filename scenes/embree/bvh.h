#pragma once
/// Embree over a SceneModel, for host and client. One Embree per process. Rays are traced by any number of threads;
/// building and moving are the owner's, alone. Callers set flush-to-zero in each tracing thread (trace_thread_init).
#include <scenes/library/model.h>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <memory>
#include <span>
#include <vector>

namespace equistream {

struct BvhOptions {
    /// Meshes placed once, and never moved, are put straight into the top level in world space, where rays find them
    /// sooner. Instances listed here keep a level of their own so that they can move.
    std::vector<std::uint32_t> moving_instances;
    unsigned threads = 0;  ///< 0: all
    /// Rays traced with Embree's own calls may bring a filter in their context (Embree 4: arguments).
    bool ray_filters = false;
};

/// What a hit is: which instance, which triangle of which mesh.
struct HitId {
    std::uint32_t instance = no_index;
    std::uint32_t triangle = no_index;
    float u = 0, v = 0;  ///< barycentrics: (1-u-v) a + u b + v c
};

class Bvh {
public:
    /// `model` is borrowed and must outlive the Bvh (vertex buffers are shared with it, not copied, where it can be).
    Bvh(const SceneModel& model, const BvhOptions& options = {});
    ~Bvh();
    Bvh(const Bvh&) = delete;
    Bvh& operator=(const Bvh&) = delete;

    /// Takes the transforms of all the model's instances (instance_transforms), puts those listed as moving where they
    /// are now and refits. Not while rays are being traced.
    void move(std::span<const glm::mat4> world_from_object);

    /// The committed top-level scene, to trace with Embree's own calls. Alpha masks are handled by its filters.
    RTCScene scene() const;
    /// From Embree's geomID / primID / instID[0] of a hit.
    HitId resolve(const RTCHit& hit) const;

    // Embree 3 and 4 take contexts and arguments differently; these do not. `coherent` is a hint.
    void intersect1(RTCRayHit& ray_hit, bool coherent = false) const;
    bool occluded1(RTCRay& ray) const;
    void intersect16(const int* valid, RTCRayHit16& ray_hits, bool coherent = true) const;

    /// Bytes Embree holds, measured by its memory monitor.
    std::size_t memory_bytes() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Sets flush-to-zero and denormals-are-zero for the calling thread, as Embree wants.
void trace_thread_init();

}  // namespace equistream
