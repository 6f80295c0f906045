#include "model.h"

#include "gltf_document.h"
#include "obj_document.h"
#include "obj_files.h"
#include "scene.h"

#include <equistream/camera_limits.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <plugin/pictures/encoded_image.h>

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

struct Box {
    glm::dvec3 low{0}, high{0};

    glm::dvec3 corner(int i) const {
        return {(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z};
    }
};

Box box_of(const Mesh& mesh) {
    if (mesh.positions.empty())
        return {};
    Box box{mesh.positions.front(), mesh.positions.front()};
    for (const glm::vec3& p : mesh.positions)
        box = {glm::min(box.low, glm::dvec3(p)), glm::max(box.high, glm::dvec3(p))};
    return box;
}

/// Rays are cast in floats, which overflow where coordinates are far beyond the limit, in the mesh or in the world.
void require_positions(const SceneModel& model) {
    const auto require = [&](const glm::dvec3& p, const std::string& what) {
        if (!is_position(p))
            throw InputError(expected_found(model.file.string() + ": " + what, "coordinates from -1e9 to 1e9",
                                            formatted("(%g, %g, %g)", p.x, p.y, p.z)));
    };
    std::vector<Box> boxes;
    for (const Mesh& mesh : model.meshes) {
        boxes.push_back(box_of(mesh));
        for (const glm::dvec3& end : {boxes.back().low, boxes.back().high})
            require(end, "mesh \"" + mesh.name + "\"");
    }
    for (const Instance& instance : model.instances)
        for (int i = 0; i < 8; ++i)
            require(glm::dmat4(instance.world_from_object) * glm::dvec4(boxes[instance.mesh].corner(i), 1),
                    "node \"" + model.objects[instance.object].name + "\", in metres");
}

SceneModel read_model(const std::filesystem::path& file, const ModelOptions& options) {
    SceneModel model = is_obj(file) ? load_obj(file, options) : load_gltf(file, options);
    model.file = file;
    return model;
}

}  // namespace

std::uint32_t SceneModel::mask_of(const Mesh& mesh) const {
    return mesh.material < materials.size() && !mesh.uvs.empty() ? materials[mesh.material].alpha_mask : no_index;
}

std::uint64_t SceneModel::triangle_count() const {
    std::uint64_t count = 0;
    for (const Instance& instance : instances)
        count += meshes[instance.mesh].triangles.size();
    return count;
}

std::uint64_t SceneModel::unique_triangle_count() const {
    std::uint64_t count = 0;
    for (const Mesh& mesh : meshes)
        count += mesh.triangles.size();
    return count;
}

SceneModel load_model(const std::filesystem::path& file, const ModelOptions& options) {
    SceneModel model = read_model(file, options);
    require_positions(model);
    return model;
}

void scale_model(SceneModel& model, double unit_m) {
    if (unit_m != 1) {
        const glm::mat4 metres = glm::scale(glm::mat4(1), glm::vec3(static_cast<float>(unit_m)));
        for (Instance& instance : model.instances)
            instance.world_from_object = metres * instance.world_from_object;
        for (Object& object : model.objects)
            object.world_from_object = metres * object.world_from_object;
    }
    require_positions(model);
}

SceneModel load_model(const SceneDescription& scene, const ModelOptions& options) {
    SceneModel model = read_model(scene.model, options);
    scale_model(model, scene.model_unit_m);
    return model;
}

namespace {

constexpr int mask_size_limit = 8192;

/// Texel that a coordinate falls on, in [0, size).
int texel(float coordinate, int size, Wrap wrap) {
    float x = coordinate;
    if (wrap == Wrap::repeat) {
        x -= std::floor(x);
    } else if (wrap == Wrap::mirror) {
        x -= 2 * std::floor(x * 0.5f);
        x = x > 1 ? 2 - x : x;
    }
    // Written so that NaN lands on texel 0.
    x = x > 0 ? std::min(x, 1.0f) : 0.0f;
    return std::min(static_cast<int>(x * static_cast<float>(size)), size - 1);
}

}  // namespace

bool AlphaMask::covers(glm::vec2 uv) const {
    const int x = texel(uv.x, width, wrap_u);
    const int y = texel(uv.y, height, wrap_v);
    return opaque[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] != 0;
}

bool AlphaMask::cuts() const {
    return std::find(opaque.begin(), opaque.end(), std::uint8_t{0}) != opaque.end();
}

AlphaMask constant_alpha_mask(bool opaque) {
    AlphaMask mask;
    mask.width = 1;
    mask.height = 1;
    mask.opaque.assign(1, opaque ? 255 : 0);
    return mask;
}

AlphaMask decode_alpha_mask(const MaskImage& image) {
    EncodedImage encoded(image.encoded, image.name, image.where);
    if (encoded.width() > mask_size_limit || encoded.height() > mask_size_limit)
        throw InputError(expected_found(image.where, "an image of 1 to 8192 pixels a side",
                                        std::to_string(encoded.width()) + "x" + std::to_string(encoded.height())));
    const int alpha = encoded.alpha_channel();
    if (alpha < 0 && !image.grey_is_alpha)
        return constant_alpha_mask(image.alpha_factor >= image.cutoff);

    const std::vector<std::uint8_t> samples = encoded.read();
    const auto channels = static_cast<std::size_t>(encoded.channels());
    const auto keep = [&](std::size_t channel) {
        AlphaMask mask;
        mask.width = encoded.width();
        mask.height = encoded.height();
        mask.opaque.resize(samples.size() / channels);
        for (std::size_t i = 0; i < mask.opaque.size(); ++i) {
            const float value = static_cast<float>(samples[i * channels + channel]) / 255.0f;
            mask.opaque[i] = value * image.alpha_factor >= image.cutoff ? 255 : 0;
        }
        return mask;
    };
    if (alpha >= 0) {
        AlphaMask mask = keep(static_cast<std::size_t>(alpha));
        if (!image.grey_is_alpha || mask.cuts())
            return mask;
    }
    return keep(0);
}

}  // namespace equistream
