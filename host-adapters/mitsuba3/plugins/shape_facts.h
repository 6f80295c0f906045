#pragma once
/// What the AOV integrator knows of each shape, looked up by what a ray hit: a hash table on the host in scalar
/// variants, arrays indexed by Dr.Jit's instance ids in the others (data and not literals, so a changed scene is no new
/// kernel).
#include <mitsuba/render/bsdf.h>
#include <mitsuba/render/scene.h>
#include <mitsuba/render/shape.h>
#include <mitsuba/render/shapegroup.h>

#include <algorithm>
#include <unordered_map>
#include <vector>

namespace equistream::mitsuba_host {

/// Whether a ray that asks for the first visible surface stops here.
enum Passage : uint32_t { stops = 0, passes = 1, by_opacity = 2 };

template <typename Float, typename Spectrum>
class ShapeFacts {
public:
    MI_IMPORT_CORE_TYPES()
    using Scene = mitsuba::Scene<Float, Spectrum>;
    using Shape = mitsuba::Shape<Float, Spectrum>;
    using BSDF = mitsuba::BSDF<Float, Spectrum>;
    using ShapePtr = dr::replace_scalar_t<Float, const Shape*>;

    ShapeFacts(const Scene* scene, bool hide_emitters) : hides_emitters_(hide_emitters) {
        const auto& shapes = scene->shapes();
        count_ = uint32_t(shapes.size());
        for (uint32_t i = 0; i < count_; ++i)
            add(shapes[i].get(), i);
        for (const auto& group : scene->shapegroups())
            for (const auto& shape : group->shapes())
                add(shape.get(), 0);
        if constexpr (dr::is_jit_v<Float>)
            upload();
    }

    /// Shapes of the scene, instances among them, those inside groups not.
    uint32_t count() const { return count_; }
    bool nothing_passes() const { return nothing_passes_; }
    bool any_without_diffuse() const { return any_without_diffuse_; }
    bool any_sharp() const { return any_sharp_; }

    /// Index in scene->shapes() of the shape, or of the instance through which it was seen.
    UInt32 index(const ShapePtr& shape, const ShapePtr& instance, const Mask& active) const {
        return resample(indices_, &Fact::index, dr::select(instance != nullptr, instance, shape), active);
    }
    UInt32 passage(const ShapePtr& shape, const Mask& active) const {
        return resample(passages_, &Fact::passage, shape, active);
    }
    /// From 1: which of the scene's BSDFs.
    UInt32 material(const ShapePtr& shape, const Mask& active) const {
        return resample(materials_, &Fact::material, shape, active);
    }

private:
    struct Fact {
        uint32_t index, passage, material;
    };

    void add(const Shape* shape, uint32_t index) {
        Fact fact{index, stops, 0};
        if (const BSDF* bsdf = shape->bsdf(); bsdf && !shape->is_instance()) {
            fact.material = materials_seen_.try_emplace(bsdf, uint32_t(materials_seen_.size() + 1)).first->second;
            fact.passage = passage_of(*bsdf);
            const uint32_t flags = bsdf->flags();
            any_without_diffuse_ |= !mitsuba::has_flag(flags, mitsuba::BSDFFlags::Diffuse);
            any_sharp_ |= (flags & uint32_t(mitsuba::BSDFFlags::Delta | mitsuba::BSDFFlags::Delta1D |
                                            mitsuba::BSDFFlags::Glossy)) != 0;
        }
        if (hides_emitters_ && shape->is_emitter())
            fact.passage = passes;
        nothing_passes_ &= fact.passage == stops;
        facts_[shape] = fact;
    }

    static uint32_t passage_of(const BSDF& bsdf) {
        return bsdf.class_name() == "Null" ? passes : bsdf.class_name() == "MaskBSDF" ? by_opacity : stops;
    }

    void upload() {
        uint32_t bound = 0;
        for (const auto& [shape, fact] : facts_)
            bound = std::max(bound, jit_registry_id(shape));
        std::vector<uint32_t> indices(bound + 1), passages(bound + 1), materials(bound + 1);
        for (const auto& [shape, fact] : facts_) {
            const uint32_t id = jit_registry_id(shape);
            indices[id] = fact.index;
            passages[id] = fact.passage;
            materials[id] = fact.material;
        }
        indices_ = dr::load<UInt32>(indices.data(), indices.size());
        passages_ = dr::load<UInt32>(passages.data(), passages.size());
        materials_ = dr::load<UInt32>(materials.data(), materials.size());
    }

    UInt32 resample(const UInt32& table, uint32_t Fact::*field, const ShapePtr& shape, const Mask& active) const {
        if constexpr (dr::is_jit_v<Float>) {
            return dr::gather<UInt32>(table, dr::reinterpret_array<UInt32>(shape), active);
        } else {
            const auto at = active ? facts_.find(shape) : facts_.end();
            return at != facts_.end() ? at->second.*field : 0;
        }
    }

    std::unordered_map<const Shape*, Fact> facts_;
    std::unordered_map<const BSDF*, uint32_t> materials_seen_;
    UInt32 indices_ = 0, passages_ = 0, materials_ = 0;
    uint32_t count_ = 0;
    bool hides_emitters_, nothing_passes_ = true, any_without_diffuse_ = false, any_sharp_ = false;
};

}  // namespace equistream::mitsuba_host
