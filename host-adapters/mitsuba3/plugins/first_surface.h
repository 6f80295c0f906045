#pragma once
/// What the AOV integrator knows of each shape, looked up by what a ray hit: a hash table on the host in scalar
/// variants, arrays indexed by Dr.Jit's instance ids in the others (data and not literals, so a changed scene is no new
/// kernel).
#include <drjit/while_loop.h>
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

// The first visible surface along a ray: null surfaces and the holes of masks are no surfaces, glass is one.

template <typename Float, typename Spectrum>
struct FirstSurface {
    MI_IMPORT_TYPES(Scene, BSDF, BSDFPtr)

    SurfaceInteraction3f si;
    Float distance;  ///< from the ray's origin; +inf for a miss

    /// `ray` with or without differentials; it is not moved, so distances add up along one straight line.
    FirstSurface(const Scene* scene, const RayDifferential3f& ray, const ShapeFacts<Float, Spectrum>& facts,
                 Mask active) {
        Float passed = 0.f;
        if (facts.nothing_passes()) {
            hit_ = scene->ray_intersect_preliminary(ray, true, active);
            rest_ = ray;
        } else {
            passed = pass_through(scene, ray, facts, active);
        }
        si = with_flags(+mitsuba::RayFlags::All, active);
        distance = dr::select(si.is_valid(), passed + si.t, dr::Infinity<Float>);
    }

    /// The same point, with what these of mitsuba::RayFlags ask for.
    SurfaceInteraction3f with_flags(uint32_t flags, Mask active) const {
        PreliminaryIntersection3f hit(hit_);  // Mitsuba asks for one that may change
        return hit.compute_surface_interaction(rest_, flags, active);
    }

private:
    /// Finds the hit and its own ray; returns how far along the ray that one begins.
    Float pass_through(const Scene* scene, const RayDifferential3f& ray, const ShapeFacts<Float, Spectrum>& facts,
                       Mask active) {
        struct LoopState {
            Float passed;
            PreliminaryIntersection3f hit;
            Mask active;
            UInt32 layers;
            DRJIT_STRUCT(LoopState, passed, hit, active, layers)
        };
        LoopState state{0.f, dr::zeros<PreliminaryIntersection3f>(), active, 0u};
        dr::tie(state) = dr::while_loop(
            dr::make_tuple(state), [](const LoopState& s) { return s.active; },
            [scene, &ray, &facts](LoopState& s) {
                const Ray3f rest = rest_of(ray, s.passed);
                s.hit = scene->ray_intersect_preliminary(rest, true, s.active);
                s.active &= s.hit.is_valid();
                const SurfaceInteraction3f here =
                    s.hit.compute_surface_interaction(rest, +mitsuba::RayFlags::All, s.active);
                s.active &= passes_through(here, facts, s.active);
                // A step that shrinks to nothing beside the coordinates would meet the same surface for ever.
                const Float step = (1.f + dr::max(dr::abs(here.p))) * mitsuba::math::RayEpsilon<Float>;
                dr::masked(s.passed, s.active) += s.hit.t + step;
                s.layers += 1u;
                s.active &= s.layers < max_layers;
            },
            "First visible surface");
        rest_ = rest_of(ray, state.passed);
        hit_ = state.hit;
        return state.passed;
    }

    static Ray3f rest_of(const RayDifferential3f& ray, const Float& passed) {
        Ray3f rest(ray);
        rest.o = dr::fmadd(ray.d, passed, ray.o);
        rest.maxt = ray.maxt - passed;
        return rest;
    }

    static Mask passes_through(const SurfaceInteraction3f& here, const ShapeFacts<Float, Spectrum>& facts,
                               const Mask& active) {
        const UInt32 passage = facts.passage(here.shape, active);
        const Mask asks = active && passage == uint32_t(by_opacity);
        Mask result = passage == uint32_t(passes);
        if (dr::any_or<true>(asks)) {
            BSDFPtr bsdf = here.bsdf();
            result |= asks && bsdf->eval_attribute_1(std::string("opacity"), here, asks) < 0.5f;
        }
        return result;
    }

    static constexpr uint32_t max_layers = 4096;

    PreliminaryIntersection3f hit_;
    Ray3f rest_;
};

}  // namespace equistream::mitsuba_host
