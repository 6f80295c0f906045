#include "bvh.h"

#include "bvh_build.h"

#include <equistream/error.h>

#include <array>
#include <atomic>
#include <cassert>
#include <limits>
#include <string>
#include <unordered_map>
#include <utility>

#if defined(__SSE__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

namespace equistream {

namespace {

DevicePointer new_device(unsigned threads) {
    const std::string config = threads > 0 ? "threads=" + std::to_string(threads) : std::string();
    DevicePointer device(rtcNewDevice(config.empty() ? nullptr : config.c_str()));
    if (!device)
        throw WorkError("Embree could not be started: error " + std::to_string(rtcGetDeviceError(nullptr)));
    return device;
}

bool count_bytes(void* counter, ssize_t bytes, bool) {
    static_cast<std::atomic<std::int64_t>*>(counter)->fetch_add(bytes, std::memory_order_relaxed);
    return true;
}

void check_model(const SceneModel& model) {
    if (model.triangle_count() == 0)
        throw InputError(expected_found("the model", "at least one triangle to trace", "none"));
    for (const Mesh& mesh : model.meshes)
        if (mesh.triangles.size() >= no_index || mesh.positions.size() >= no_index)
            throw InputError(expected_found("mesh " + mesh.name, "fewer than 2^32 - 1 triangles and vertices", "more"));
}

std::vector<bool> moving_flags(const SceneModel& model, const std::vector<std::uint32_t>& moving) {
    std::vector<bool> flags(model.instances.size(), false);
    for (const std::uint32_t instance : moving) {
        if (instance >= flags.size())
            throw InputError(expected_found("moving instances", "numbers below " + std::to_string(flags.size()),
                                            std::to_string(instance)));
        flags[instance] = true;
    }
    return flags;
}

#if RTC_VERSION_MAJOR < 4
RTCIntersectContext context_for(bool coherent) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return context;
}
#endif

}  // namespace

/// Without moving instances everything unmoving and unshared lies flat in the top scene beside the instances. With
/// them it lies in `still`, one instance of the top scene, so that a move rebuilds over placements, not triangles.
struct Bvh::State {
    State(const SceneModel& scene_model, const BvhOptions& options)
        : device(new_device(options.threads)), builder(device.get(), scene_model, options.ray_filters) {
        rtcSetDeviceMemoryMonitorFunction(device.get(), count_bytes, &bytes);
        const std::vector<bool> moving = moving_flags(scene_model, options.moving_instances);
        const std::vector<Placement> placements = choose_placements(scene_model, moving);
        const bool moves = !options.moving_instances.empty();
        top = builder.new_scene();
        if (moves)
            still = builder.new_scene();
        geometry_of_instance.assign(scene_model.instances.size(), RTC_INVALID_GEOMETRY_ID);
        add_flat(scene_model, placements, moves ? still.get() : top.get());
        add_instances(scene_model, placements);
        builder.commit(top.get());
        for (const std::uint32_t instance : options.moving_instances)
            mover_geometry[instance] = rtcGetGeometry(top.get(), geometry_of_instance[instance]);
    }

    void add_flat(const SceneModel& model, const std::vector<Placement>& placements, RTCScene into) {
        for (std::uint32_t i = 0; i < placements.size(); ++i) {
            if (placements[i] != Placement::flat)
                continue;
            const Instance& instance = model.instances[i];
            record(flat_instance, builder.add_mesh(into, instance.mesh, &instance.world_from_object), i);
        }
        if (still && !flat_instance.empty()) {
            builder.commit(still.get());
            still_id = builder.add_instance(top.get(), still.get(), glm::mat4(1));
        }
    }

    void add_instances(const SceneModel& model, const std::vector<Placement>& placements) {
        for (std::uint32_t i = 0; i < placements.size(); ++i) {
            if (placements[i] != Placement::instance)
                continue;
            const Instance& instance = model.instances[i];
            const std::uint32_t id =
                builder.add_instance(top.get(), builder.mesh_scene(instance.mesh), instance.world_from_object);
            geometry_of_instance[i] = id;
            record(instance_of_top, id, i);
        }
    }

    static void record(std::vector<std::uint32_t>& table, std::uint32_t id, std::uint32_t instance) {
        if (id >= table.size())
            table.resize(id + std::size_t{1}, no_index);
        table[id] = instance;
    }

    std::atomic<std::int64_t> bytes{0};  ///< outlives the device, which reports to it
    DevicePointer device;
    BvhBuilder builder;
    ScenePointer top;
    ScenePointer still;
    std::uint32_t still_id = RTC_INVALID_GEOMETRY_ID;
    std::vector<std::uint32_t> flat_instance;    ///< by geometry id in the scene that holds flat meshes
    std::vector<std::uint32_t> instance_of_top;  ///< by geometry id of instances in the top scene
    std::vector<std::uint32_t> geometry_of_instance;
    std::unordered_map<std::uint32_t, RTCGeometry> mover_geometry;  ///< by instance; the scene owns them
};

Bvh::Bvh(const SceneModel& model, const BvhOptions& options) {
    check_model(model);
    state_ = std::make_unique<State>(model, options);
}

Bvh::~Bvh() = default;

void Bvh::move(std::span<const glm::mat4> world_from_object) {
    for (const auto& [instance, geometry] : state_->mover_geometry) {
        assert(instance < world_from_object.size());
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &world_from_object[instance][0][0]);
        rtcCommitGeometry(geometry);
    }
    state_->builder.commit(state_->top.get());
}

RTCScene Bvh::scene() const {
    return state_->top.get();
}

HitId Bvh::resolve(const RTCHit& hit) const {
    HitId id;
    if (hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return id;
    const bool flat = hit.instID[0] == RTC_INVALID_GEOMETRY_ID || hit.instID[0] == state_->still_id;
    id.instance = flat ? state_->flat_instance[hit.geomID] : state_->instance_of_top[hit.instID[0]];
    id.triangle = hit.primID;
    id.u = hit.u;
    id.v = hit.v;
    return id;
}

#if RTC_VERSION_MAJOR >= 4

void Bvh::intersect1(RTCRayHit& ray_hit, bool coherent) const {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect1(state_->top.get(), &ray_hit, &arguments);
}

bool Bvh::occluded1(RTCRay& ray) const {
    rtcOccluded1(state_->top.get(), &ray, nullptr);
    return ray.tfar < 0;
}

void Bvh::intersect16(const int* valid, RTCRayHit16& ray_hits, bool coherent) const {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect16(valid, state_->top.get(), &ray_hits, &arguments);
}

#else

namespace {

/// Where a processor has no registers of 16 lanes, Embree 3 takes a packet for a stream of rays and does not look at
/// `valid`: only rays that end before they begin are left alone there. They get their ends back.
class EmptyLanes {
public:
    EmptyLanes(const int* valid, RTCRay16& rays) : valid_(valid), rays_(rays) {
        for (std::size_t lane = 0; lane < tfar_.size(); ++lane)
            if (valid[lane] == 0)
                tfar_[lane] = std::exchange(rays.tfar[lane], -std::numeric_limits<float>::infinity());
    }
    ~EmptyLanes() {
        for (std::size_t lane = 0; lane < tfar_.size(); ++lane)
            if (valid_[lane] == 0)
                rays_.tfar[lane] = tfar_[lane];
    }
    EmptyLanes(const EmptyLanes&) = delete;
    EmptyLanes& operator=(const EmptyLanes&) = delete;

private:
    const int* valid_;
    RTCRay16& rays_;
    std::array<float, 16> tfar_{};
};

}  // namespace

void Bvh::intersect1(RTCRayHit& ray_hit, bool coherent) const {
    RTCIntersectContext context = context_for(coherent);
    rtcIntersect1(state_->top.get(), &context, &ray_hit);
}

bool Bvh::occluded1(RTCRay& ray) const {
    RTCIntersectContext context = context_for(false);
    rtcOccluded1(state_->top.get(), &context, &ray);
    return ray.tfar < 0;
}

void Bvh::intersect16(const int* valid, RTCRayHit16& ray_hits, bool coherent) const {
    RTCIntersectContext context = context_for(coherent);
    const EmptyLanes empty(valid, ray_hits.ray);
    rtcIntersect16(valid, state_->top.get(), &context, &ray_hits);
}

#endif

std::size_t Bvh::memory_bytes() const {
    return static_cast<std::size_t>(state_->bytes.load());
}

void trace_thread_init() {
#if defined(__SSE__)
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
}

}  // namespace equistream
