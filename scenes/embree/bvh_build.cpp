#include "bvh_build.h"

#include <equistream/error.h>

#include <cassert>
#include <cmath>
#include <string>

namespace equistream {

namespace {

#if RTC_VERSION_MAJOR >= 4
constexpr RTCSceneFlags ray_filter_flag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
constexpr RTCSceneFlags ray_filter_flag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif

/// Drops hits that fall on cut-away texels. Barycentrics: u belongs to the second vertex, v to the third.
void filter_by_mask(const RTCFilterFunctionNArguments* arguments) {
    const auto& masked = *static_cast<const MaskedMesh*>(arguments->geometryUserPtr);
    const unsigned n = arguments->N;
    for (unsigned i = 0; i < n; ++i) {
        if (arguments->valid[i] != -1)
            continue;
        const CornerUvs& uvs = masked.uvs[RTCHitN_primID(arguments->hit, n, i)];
        const float u = RTCHitN_u(arguments->hit, n, i);
        const float v = RTCHitN_v(arguments->hit, n, i);
        if (!masked.mask->covers(uvs.a + u * uvs.ab + v * uvs.ac))
            arguments->valid[i] = 0;
    }
}

std::vector<CornerUvs> corner_uvs(const Mesh& mesh) {
    std::vector<CornerUvs> corners;
    corners.reserve(mesh.triangles.size());
    for (const glm::uvec3& t : mesh.triangles)
        corners.push_back({mesh.uvs[t.x], mesh.uvs[t.y] - mesh.uvs[t.x], mesh.uvs[t.z] - mesh.uvs[t.x]});
    return corners;
}

/// Embree reads 16 bytes at every vertex, so the last of a shared buffer needs memory behind it.
bool sharable(const std::vector<glm::vec3>& positions) {
    return positions.capacity() > positions.size();
}

void set_vertices(RTCGeometry geometry, const Mesh& mesh, const glm::mat4* world_from_object) {
    const bool in_place = !world_from_object || *world_from_object == glm::mat4(1);
    if (in_place && sharable(mesh.positions)) {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.positions.data(), 0,
                                   sizeof(glm::vec3), mesh.positions.size());
        return;
    }
    auto* to = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               sizeof(glm::vec3), mesh.positions.size()));
    if (!to)
        return;  // out of memory, which check_device reports
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        to[i] = in_place ? mesh.positions[i] : glm::vec3(*world_from_object * glm::vec4(mesh.positions[i], 1));
}

}  // namespace

void check_device(RTCDevice device, const char* doing) {
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_NONE)
        return;
    const std::string what = error == RTC_ERROR_OUT_OF_MEMORY ? "out of memory" : "error " + std::to_string(error);
    throw WorkError(std::string("Embree, ") + doing + ": " + what);
}

std::vector<Placement> choose_placements(const SceneModel& model, const std::vector<bool>& moving) {
    std::vector<std::uint32_t> times_placed(model.meshes.size(), 0);
    for (const Instance& instance : model.instances)
        ++times_placed[instance.mesh];
    std::vector<Placement> placements(model.instances.size(), Placement::instance);
    for (std::size_t i = 0; i < placements.size(); ++i) {
        const Instance& instance = model.instances[i];
        const float volume = glm::determinant(glm::mat3(instance.world_from_object));
        if (!moving[i] && (times_placed[instance.mesh] == 1 || !std::isnormal(volume)))
            placements[i] = Placement::flat;
    }
    return placements;
}

ScenePointer BvhBuilder::new_scene() const {
    ScenePointer scene(rtcNewScene(device_));
    if (!scene)
        check_device(device_, "making a scene");
    // Robust: no ray may slip through an edge that two triangles share. Without it about 1 in 15 rays aimed at edges
    // of an icosphere does; with it none, and of those aimed exactly at vertices fewer than 1 in 100.
    rtcSetSceneFlags(scene.get(), ray_filters_ ? RTC_SCENE_FLAG_ROBUST | ray_filter_flag : RTC_SCENE_FLAG_ROBUST);
    return scene;
}

void BvhBuilder::commit(RTCScene scene) const {
    rtcCommitScene(scene);
    check_device(device_, "building");
}

std::uint32_t BvhBuilder::add_mesh(RTCScene scene, std::uint32_t mesh_index, const glm::mat4* world_from_object) {
    const Mesh& mesh = model_.meshes[mesh_index];
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    set_vertices(geometry, mesh, world_from_object);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                               sizeof(glm::uvec3), mesh.triangles.size());
    const std::uint32_t mask = model_.mask_of(mesh);
    if (mask != no_index) {
        masked_.push_back(std::make_unique<MaskedMesh>(MaskedMesh{corner_uvs(mesh), &mask_bits(mask)}));
        rtcSetGeometryUserData(geometry, masked_.back().get());
        rtcSetGeometryIntersectFilterFunction(geometry, filter_by_mask);
        rtcSetGeometryOccludedFilterFunction(geometry, filter_by_mask);
    }
    rtcCommitGeometry(geometry);
    const std::uint32_t id = rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    check_device(device_, "adding a mesh");
    return id;
}

std::uint32_t BvhBuilder::add_instance(RTCScene scene, RTCScene of, const glm::mat4& world_from_object) const {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, of);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &world_from_object[0][0]);
    rtcCommitGeometry(geometry);
    const std::uint32_t id = rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    check_device(device_, "adding an instance");
    return id;
}

const MaskBits& BvhBuilder::mask_bits(std::uint32_t mask) {
    mask_bits_.resize(model_.alpha_masks.size());
    if (!mask_bits_[mask])
        mask_bits_[mask] = std::make_unique<MaskBits>(model_.alpha_masks[mask]);
    return *mask_bits_[mask];
}

RTCScene BvhBuilder::mesh_scene(std::uint32_t mesh) {
    mesh_scenes_.resize(model_.meshes.size());
    if (!mesh_scenes_[mesh]) {
        ScenePointer scene = new_scene();
        add_mesh(scene.get(), mesh, nullptr);
        commit(scene.get());
        mesh_scenes_[mesh] = std::move(scene);
    }
    return mesh_scenes_[mesh].get();
}

MaskBits::MaskBits(const AlphaMask& mask)
    : mask_(mask), width_(mask.width), height_(mask.height), blocks_across_((static_cast<unsigned>(width_) + 7) / 8),
      repeats_(mask.wrap_u == Wrap::repeat && mask.wrap_v == Wrap::repeat) {
    if (!repeats_)
        return;
    blocks_.assign(std::size_t{blocks_across_} * ((static_cast<unsigned>(height_) + 7) / 8), 0);
    std::size_t texel = 0;
    for (unsigned y = 0; y < static_cast<unsigned>(height_); ++y)
        for (unsigned x = 0; x < static_cast<unsigned>(width_); ++x, ++texel)
            if (mask.opaque[texel] != 0)
                blocks_[(y >> 3) * blocks_across_ + (x >> 3)] |= std::uint64_t{1} << ((y & 7u) * 8 + (x & 7u));
}

}  // namespace equistream
