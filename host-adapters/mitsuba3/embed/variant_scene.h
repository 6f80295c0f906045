#pragma once
/// EmbeddedScene for one variant of Mitsuba. Included only by the sources that instantiate it.
#include "edited_xml.h"
#include "ray_tracer.h"
#include "variant_arrays.h"

#include <host-adapters/mitsuba3/plugins/parameters.h>

#include "embedded_scene.h"

#include <mitsuba/core/properties.h>
#include <mitsuba/render/bsdf.h>
#include <mitsuba/render/film.h>
#include <mitsuba/render/integrator.h>
#include <mitsuba/render/scene.h>
#include <mitsuba/render/sensor.h>
#include <mitsuba/render/shape.h>
#include <mitsuba/render/texture.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace equistream::mitsuba_host {

template <typename Float, typename Spectrum>
class VariantScene final : public EmbeddedScene {
public:
    using Arrays = VariantArrays<Float>;
    using Scene = mitsuba::Scene<Float, Spectrum>;
    using Sensor = mitsuba::Sensor<Float, Spectrum>;
    using Shape = mitsuba::Shape<Float, Spectrum>;
    using Integrator = mitsuba::SamplingIntegrator<Float, Spectrum>;
    using Texture = mitsuba::Texture<Float, Spectrum>;
    using Floats = typename Arrays::Floats;
    using Integers = typename Arrays::Integers;
    using Transform = typename Arrays::Transform;

    VariantScene(mitsuba::ref<mitsuba::Object> root, const EditedXml& xml, const SceneRequest& request);

    const XmlSensor& xml_sensor() const override { return xml_sensor_; }
    const std::vector<ShapeSummary>& shapes() const override { return shapes_; }
    const std::vector<ShapeGroup>& groups() const override { return groups_; }
    MeshBuffers mesh(int group, std::size_t shape) override;
    OpacityMap opacity(int group, std::size_t shape) override;
    std::vector<std::uint32_t> face_instances(std::size_t shape) override;
    void set_ids(const ShapeIds& ids) override;
    void set_moved(const std::vector<float>& previous, const std::vector<float>& next) override;
    void place_instance(std::size_t shape, const Matrix34& world_from_group) override;
    void place_vertices(std::size_t shape, const std::vector<float>& positions,
                        const std::vector<float>& normals) override;
    void commit_placements() override { scene_->parameters_changed({}); }
    void place_camera(std::size_t sensor, const CameraPlacement& placement) override;
    PassResult render(std::size_t sensor, std::uint32_t samples, std::uint32_t seed, bool aovs, bool guides) override;
    std::vector<float> distances(const RayBatch& rays) override { return ray_tracer().distances(rays); }
    std::vector<float> guides(const RayBatch& rays) override { return ray_tracer().guides(rays); }
    std::vector<std::uint32_t> ids(const RayBatch& rays) override { return ray_tracer().ids(rays); }
    std::vector<float> radiance(const RayBatch& rays, std::size_t sensor, std::uint32_t seed) override {
        return ray_tracer().radiance(rays, *colour_alone_, *sensors_[sensor], seed);
    }

private:
    /// Made when it is first asked for.
    RayTracer<Float, Spectrum>& ray_tracer() {
        if (!rays_)
            rays_.emplace(scene_.get(), hides_emitters_, ids_);
        return *rays_;
    }
    void find_sensors(std::size_t count);
    void find_integrators();
    void find_shapes(const EditedXml& xml);
    ShapeSummary summary(Shape& shape) const;
    Shape& shape_at(int group, std::size_t index);
    void keep_colour_only(PassResult& pass);
    void count_hits(Integrator& integrator, Sensor& sensor, std::uint32_t samples, std::uint32_t seed,
                    PassResult& pass);

    mitsuba::ref<Scene> scene_;
    std::vector<mitsuba::ref<Sensor>> sensors_;
    mitsuba::ref<Integrator> with_aovs_, colour_alone_, hits_, guides_;
    std::vector<std::vector<Shape*>> members_;  // of groups_
    XmlSensor xml_sensor_;
    bool hides_emitters_ = false;
    std::vector<ShapeSummary> shapes_;
    std::vector<ShapeGroup> groups_;
    ShapeIds ids_;
    std::optional<RayTracer<Float, Spectrum>> rays_;
};

template <typename Float, typename Spectrum>
VariantScene<Float, Spectrum>::VariantScene(mitsuba::ref<mitsuba::Object> root, const EditedXml& xml,
                                            const SceneRequest& request)
    : scene_(dynamic_cast<Scene*>(root.get())), xml_sensor_(xml.sensor), hides_emitters_(xml.hides_emitters) {
    if (!scene_)
        throw std::runtime_error("expected a scene of this variant");
    find_sensors(request.sensors.size());
    find_integrators();
    find_shapes(xml);
}

template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::find_sensors(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        for (auto& sensor : scene_->sensors())
            if (sensor->id() == our_sensor_id(i))
                sensors_.push_back(sensor);
    if (sensors_.size() != count)
        throw std::runtime_error("Mitsuba kept " + std::to_string(sensors_.size()) + " of " + std::to_string(count) +
                                 " sensors");
}

template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::find_integrators() {
    with_aovs_ = dynamic_cast<Integrator*>(scene_->integrator());
    const Parameters parameters(*with_aovs_);
    for (const auto& [name, object] : parameters.objects())
        if (auto* integrator = dynamic_cast<Integrator*>(object))
            colour_alone_ = integrator;
    if (!colour_alone_)
        throw std::runtime_error("equirect_aov: expected to show its nested integrator");
    // Mitsuba's alpha is 1 where a ray meets the sky or fog; ours says whether it met a surface.
    hits_ = new HitIntegrator<Float, Spectrum>(hides_emitters_, false);
    guides_ = new HitIntegrator<Float, Spectrum>(hides_emitters_, true);
}

template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::find_shapes(const EditedXml& xml) {
    for (auto& group : scene_->shapegroups()) {
        groups_.push_back({std::string(group->id()), {}});
        members_.emplace_back();
        const Parameters parameters(*group);
        for (const auto& [name, object] : parameters.objects())
            if (auto* member = dynamic_cast<Shape*>(object)) {
                members_.back().push_back(member);
                groups_.back().shapes.push_back(summary(*member));
            }
    }
    for (auto& shape : scene_->shapes()) {
        ShapeSummary found = summary(*shape);
        if (const auto group = xml.group_of_instance.find(found.id); group != xml.group_of_instance.end())
            for (std::size_t i = 0; i < groups_.size(); ++i)
                if (groups_[i].id == group->second)
                    found.group = static_cast<int>(i);
        shapes_.push_back(std::move(found));
    }
}

template <typename Float, typename Spectrum>
ShapeSummary VariantScene<Float, Spectrum>::summary(Shape& shape) const {
    const Parameters parameters(shape);
    ShapeSummary result;
    result.id = shape.id();
    result.class_name = shape.class_name();
    result.is_mesh = parameters.template find<Floats>("vertex_positions") != nullptr;
    if (const Transform* to_world = parameters.template find<Transform>("to_world"))
        result.to_world = Arrays::rows_of(*to_world);
    if (const mitsuba::Object* bsdf = parameters.object("bsdf"))
        result.bsdf = bsdf->id(), result.is_invisible = bsdf->class_name() == "Null";
    result.is_invisible |= hides_emitters_ && shape.is_emitter();
    return result;
}

template <typename Float, typename Spectrum>
typename VariantScene<Float, Spectrum>::Shape& VariantScene<Float, Spectrum>::shape_at(int group, std::size_t index) {
    if (group < 0)
        return *scene_->shapes().at(index);
    return *members_.at(static_cast<std::size_t>(group)).at(index);
}

template <typename Float, typename Spectrum>
MeshBuffers VariantScene<Float, Spectrum>::mesh(int group, std::size_t shape) {
    const Parameters parameters(shape_at(group, shape));
    return {Arrays::to_host(parameters.template get<Floats>("vertex_positions")),
            Arrays::to_host(parameters.template get<Floats>("vertex_normals")),
            Arrays::to_host(parameters.template get<Floats>("vertex_texcoords")),
            Arrays::to_host(parameters.template get<Integers>("faces"))};
}

template <typename Float, typename Spectrum>
std::vector<std::uint32_t> VariantScene<Float, Spectrum>::face_instances(std::size_t shape) {
    const Floats* of_faces = Parameters(shape_at(-1, shape)).template find<Floats>("face_instance");
    if (of_faces == nullptr)
        return {};
    const std::vector<float> instances = Arrays::to_host(*of_faces);
    return {instances.begin(), instances.end()};
}

template <typename Float, typename Spectrum>
OpacityMap VariantScene<Float, Spectrum>::opacity(int group, std::size_t shape) {
    mitsuba::Object* bsdf = Parameters(shape_at(group, shape)).object("bsdf");
    while (bsdf != nullptr && Parameters(*bsdf).object("brdf_0") != nullptr)  // twosided
        bsdf = Parameters(*bsdf).object("brdf_0");
    auto* texture = bsdf ? dynamic_cast<Texture*>(Parameters(*bsdf).object("opacity")) : nullptr;
    if (texture == nullptr)
        return {};
    constexpr int most = 8192, enough = 1024;
    const auto resolution = texture->resolution();
    const auto repeats = Arrays::repeats_of(Parameters(*texture));
    const auto side = [&](int axis) {
        const double texels = resolution[axis] * repeats[static_cast<std::size_t>(axis)];
        return std::clamp(static_cast<int>(std::lround(texels)), 1, most);
    };
    OpacityMap map{side(0), side(1), {}};
    if (texture->is_spatially_varying()) {
        // Filtered, its edge runs between texels, and a formula has none: finer ones follow both.
        const int finer = std::max(1, enough / std::max(map.width, map.height));
        map.width *= resolution[0] > 1 ? std::min(finer, 4) : finer;
        map.height *= resolution[1] > 1 ? std::min(finer, 4) : finer;
    }
    map.opacity = Arrays::evaluated(map.width, map.height, [&](const auto& uv) {
        auto si = drjit::zeros<mitsuba::SurfaceInteraction<Float, Spectrum>>();
        si.uv = {uv.first, uv.second};
        return texture->eval_1(si, true);
    });
    return map;
}

template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::set_ids(const ShapeIds& ids) {
    ids_ = ids;
    const Parameters parameters(*with_aovs_);
    parameters.template get<Integers>("object_id") = Arrays::integers(ids.object);
    parameters.template get<Integers>("material_id") = Arrays::integers(ids.material);
    parameters.template get<Integers>("instance_id") = Arrays::integers(ids.instance);
    if (!ids.face_entry.empty()) {
        parameters.template get<Integers>("first_face") = Arrays::integers(ids.first_face);
        parameters.template get<Integers>("face_entry") = Arrays::integers(ids.face_entry);
    }
    with_aovs_->parameters_changed({"object_id", "material_id", "instance_id", "first_face", "face_entry"});
}

template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::set_moved(const std::vector<float>& previous, const std::vector<float>& next) {
    const Parameters parameters(*with_aovs_);
    parameters.template get<Floats>("moved_previous") = Arrays::floats(previous);
    parameters.template get<Floats>("moved_next") = Arrays::floats(next);
    with_aovs_->parameters_changed({"moved_previous", "moved_next"});
}

template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::place_instance(std::size_t shape, const Matrix34& world_from_group) {
    Shape& instance = shape_at(-1, shape);
    Parameters(instance).template get<Transform>("to_world") = Arrays::transform(world_from_group);
    instance.parameters_changed({"to_world"});
}

template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::place_vertices(std::size_t shape, const std::vector<float>& positions,
                                                   const std::vector<float>& normals) {
    Shape& mesh = shape_at(-1, shape);
    const Parameters parameters(mesh);
    parameters.template get<Floats>("vertex_positions") = Arrays::floats(positions);
    std::vector<std::string> changed{"vertex_positions"};
    if (!normals.empty()) {
        parameters.template get<Floats>("vertex_normals") = Arrays::floats(normals);
        changed.emplace_back("vertex_normals");
    }
    mesh.parameters_changed(changed);
}

template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::place_camera(std::size_t sensor, const CameraPlacement& placement) {
    const Parameters own(*sensors_[sensor]), integrators(*with_aovs_);
    // A flat camera knows no other frame; the integrator does for it.
    const bool knows_neighbours = own.has("to_world_previous");
    const Parameters& neighbours = knows_neighbours ? own : integrators;
    own.template get<Transform>("to_world") = Arrays::transform(placement.now);
    neighbours.template get<Transform>("to_world_previous") = Arrays::transform(placement.previous);
    neighbours.template get<Transform>("to_world_next") = Arrays::transform(placement.next);
    if (placement.range) {
        using Number = dr::scalar_t<Float>;
        own.template get<Number>("longitude_min") = static_cast<Number>(placement.range->longitude_min_deg);
        own.template get<Number>("longitude_max") = static_cast<Number>(placement.range->longitude_max_deg);
        own.template get<Number>("latitude_min") = static_cast<Number>(placement.range->latitude_min_deg);
        own.template get<Number>("latitude_max") = static_cast<Number>(placement.range->latitude_max_deg);
    }
    if (knows_neighbours) {
        sensors_[sensor]->parameters_changed({"to_world", "to_world_previous", "to_world_next"});
    } else {
        sensors_[sensor]->parameters_changed({"to_world"});
        with_aovs_->parameters_changed({"to_world_previous", "to_world_next"});
    }
}

template <typename Float, typename Spectrum>
PassResult VariantScene<Float, Spectrum>::render(std::size_t sensor, std::uint32_t samples, std::uint32_t seed,
                                                 bool aovs, bool guides) {
    Integrator& integrator = aovs ? *with_aovs_ : *colour_alone_;
    PassResult pass;
    pass.channels = {"R", "G", "B", "A"};
    for (const std::string& name : integrator.aov_names())
        pass.channels.push_back(name);
    auto image = integrator.render(scene_.get(), sensors_[sensor].get(), seed, samples);
    if (image.shape(2) != pass.channels.size())  // `aov` returns less than the film has
        image = sensors_[sensor]->film()->develop();
    pass.values = Arrays::to_host(image.array());
    if (image.shape(2) != pass.channels.size())
        throw std::runtime_error("expected " + std::to_string(pass.channels.size()) +
                                 " channels of the integrator, found " + std::to_string(image.shape(2)));
    if (!aovs)
        keep_colour_only(pass);
    count_hits(guides ? *guides_ : *hits_, *sensors_[sensor], samples, seed, pass);
    return pass;
}

/// An integrator of the XML may have channels of its own.
template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::keep_colour_only(PassResult& pass) {
    const std::size_t channels = pass.channels.size(), pixels = pass.values.size() / channels;
    for (std::size_t i = 0; channels > 4 && i < pixels; ++i)
        std::copy_n(&pass.values[i * channels], 4, &pass.values[i * 4]);
    pass.values.resize(pixels * 4);
    pass.channels.resize(4);
}

/// With the same seed the sampler gives the same places in the pixels.
template <typename Float, typename Spectrum>
void VariantScene<Float, Spectrum>::count_hits(Integrator& integrator, Sensor& sensor, std::uint32_t samples,
                                               std::uint32_t seed, PassResult& pass) {
    const std::vector<float> hits = Arrays::to_host(integrator.render(scene_.get(), &sensor, seed, samples).array());
    const std::size_t channels = pass.channels.size(), pixels = pass.values.size() / channels;
    const std::size_t hit_channels = hits.size() / pixels;
    for (std::size_t i = 0; i < pixels; ++i)
        pass.values[i * channels + 3] = hits[i * hit_channels + 3];
    const std::size_t guide_count = integrator.aov_names().size();
    for (std::size_t i = 0; i < pixels && guide_count > 0; ++i)
        pass.guides.insert(pass.guides.end(), &hits[(i + 1) * hit_channels - guide_count],
                           &hits[(i + 1) * hit_channels - 1] + 1);
}

/// What each source that instantiates the class exports.
template <typename Float, typename Spectrum>
std::unique_ptr<EmbeddedScene> make_variant_scene(mitsuba::ref<mitsuba::Object> root, const EditedXml& xml,
                                                  const SceneRequest& request);

#define EQUISTREAM_VARIANT_SCENE(Float, ...)                                                                           \
    template <>                                                                                                        \
    std::unique_ptr<EmbeddedScene> make_variant_scene<Float, __VA_ARGS__>(                                             \
        mitsuba::ref<mitsuba::Object> root, const EditedXml& xml, const SceneRequest& request) {                       \
        return std::make_unique<VariantScene<Float, __VA_ARGS__>>(std::move(root), xml, request);                      \
    }

}  // namespace equistream::mitsuba_host
